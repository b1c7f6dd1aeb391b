//! Files of `cargo replay`, as its help has them.

pub const FORMATS: &str = "\
Frame: the outer rings stand still, the shaft turns about +x. Loads act on the inner ring of a
bearing, moments about its centre; on the shaft of a spindle at x = 0. Azimuths count from +y
towards +z.

DESIGN.toml is a spindle if it has [[row]]s:
  name = \"7014C back to back\"
  preload_n = 294               # as ground: of a pair of such bearings on rigid seats
                                # or mounted_preload_n, between the rows as they are built in: on their
                                # supports and shaft, at rest, cold, without loads
                                # or for each row preload_offset_um, its closure, which adds up with that
                                # of the row it faces (a spacer 10 um short: 10 in one of them, or 5 in
                                # both); or spring = true
  [[row]]
  bearing = \"7014c.toml\"       # beside this file; a name of the catalogue; or its keys under
                                # [row.design]
                                # ball = { youngs_modulus_gpa = 310, .. } for balls of another material
  position_mm = 0
  facing = \"+x\"               # a load on the shaft in +x presses its balls
  radial_growth_um = 2          # and axial_, ball_growth_um; may be left out
  [[row]]                       # back to back: +x at the smaller x, -x at the larger
  bearing = \"7014c.toml\"
  position_mm = 27
  facing = \"-x\"
  [spring]                      # of the rows with spring = true: force_n = 300
  [shaft]                       # rings grow with the speed on a shaft with bore_mm = 40
  sections = [                  # or a shaft that bends, rigid outside of them and in gaps
    { from_mm = -30, to_mm = 90, outer_mm = 70, inner_mm = 30 },
  ]
  grow_with_speed = true        # rings grow on the bores of the sections; youngs_modulus_gpa = 206
  [heat]                        # growth with temperatures: reference_c = 20; shaft_per_k, housing_per_k,
                                # ring_per_k, ball_per_k of bearing steel (11.5e-6) if left out
  [nose]                        # stiffness there, too: position_mm = -60, radial_um_per_kn,
                                # axial_um_per_kn, both of a shaft without sections
  [nose.tool]                   # more of them, by name: position_mm = -120
  [[probe]]                     # sees the shaft against the housing, for --response: name = \"nose\",
                                # position_mm = -10, angle_deg = 90 from +y towards +z, or
                                # direction = \"x\"; accuracy_um = 0.5
A [[row]] may stand on an elastic support; what is left out is rigid:
  support = { axial_n_per_um = 500, radial_n_per_um = 400, tilting_nm_per_rad = 1e6 }

DESIGN.toml of either kind may say where recorded loads act, and what acts besides:
  [load]                        # on an elastic shaft, all loads act where they stand
  position_mm = -60
  [[constant_load]]             # belt, gear, weight: fx_n, fy_n, fz_n at
  position_mm = 120

LOADS.csv has the columns
  time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm
in any order, names on the first line, fields separated by commas, semicolons or tabs, decimals by points, text in UTF-8;
for a spindle with [heat] t_inner_c,t_outer_c as well; for --response and --limits probe_NAME_um of each [[probe]]. Other
columns are ignored, and named once on standard error. Without time_s, rows are counted. Any other file is refused, with the
lines of Python that make a recording of it; a column in another unit, such as fx_kn, with the unit that is due.
A row that cannot be read to the letter is refused. A line on standard error counts rows that were read or refused, and lines
that were skipped, with the range of each quantity.

A table, in place of LOADS.csv:
  cargo replay DESIGN.toml --table speed=0:20000:500 fx=500 fy=0:1000:250 >TABLE.csv
  cargo plot TABLE.csv --over speed
It has the columns of the results. docs/host.md makes a bearing of ROSS of such stiffness.

Results, one row for each row of LOADS.csv, SI units:
  time_s          copied
  status          converged; precision-limit (as close as the precision allows);
                  anything else means that this row has no answer, and its figures are empty:
                  unseated (the speed drives a ball out of its groove), iteration-limit (ran out
                  of iterations), refused-input (a field of LOADS.csv is empty or no number, the line has
                  too few or too many fields) and so on
  iterations      passes over all balls that the solve took
  dx_m .. tz_rad  displacement of the inner ring, or of the shaft at x = 0
  k_x_x .. k_tz_tz  stiffness, 25 columns: k_y_tz is the change of Fy with the tilt tz
  k_nose_x_x k_nose_y_y k_nose_z_z k_nose_ty_ty k_nose_tz_tz
                  of a spindle with [nose], the stiffness that a force or moment alone meets
                  there: 1 over the compliance, as a dial gauge finds it
  limits          physical limits that are passed, a blank between two of them; empty if none is:
                  peak-pressure (of a contact); shoulder (a contact's centre is past it); truncation
                  (of a contact ellipse by the shoulder); reversal (of a contact angle); friction
                  (more is called for, gross slip suspected); inner-contact (lost by a ball);
                  lift-off (no preload is left)
  fx_n .. speed_rpm  loads and speed, copied
  t_inner_c, t_outer_c  at the end, of a spindle with [heat]; reaction_fx_n .. with --given
  l10_mrev, l10_h    basic rating life by ISO/TS 16281 under this load, million revolutions and hours;
                  with dynamic_load_rating_n of DESIGN.toml, else with ISO 281's C, 5 % to 8 % high

BALLS.csv, one row for each ball of each row, balls numbered from 0 at the first azimuth:
  time_s,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,
  p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o
  contact angles and contact forces at the inner and outer race, centrifugal force, gyroscopic
  moment; peak pressures, semi-axes of the contact ellipses across (a) and along (b) the rolling
  direction; speed about the bearing's axis, angle of the axis of its own rotation to that axis,
  angular speed of spin over that of rolling. A ball off the inner race has 0 for that contact;
  rows without an answer have empty figures here, too. Of a spindle, `row` comes before `ball`.

FREQUENCIES.csv, one row for each row of balls; of a spindle, `row` comes after `time_s`:
  time_s,cage_hz,outer_race_hz,inner_race_hz,ball_hz
  turns of the cage (FTF); balls past a point of the outer and of the inner race (BPFO, BPFI); turns
  of a ball seen from the cage (BSF: a damaged ball meets both races in each)

ROWS.csv, one row for each row of balls, numbered from 0 as in DESIGN.toml, in the row's own frame,
whose x points where an axial load presses its balls:
  time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n
  load on its inner ring about its centre; what of the axial one is preload; least force of a ball
then in the shaft's frame, SI units:
  k_row_x_x .. k_row_tz_tz  stiffness between shaft and housing: of the row, its support in series
  dx_m .. tz_rad  displacement of the shaft at the row
then closure_um, by which the row's rings are ground or set off against each other; 0 under a spring,
and l10_mrev, l10_h, its basic rating life as in the results

NOSES.csv, one row for each nose, the plain one being called nose:
  time_s,nose,dx_m,dy_m,dz_m,ty_rad,tz_rad,c_x_x .. c_tz_tz,c_error_x .. c_error_tz
  displacement of the shaft there; flexibility: c_y_tz is the change of dy with the moment Mz;
  estimated relative errors of c_x_x, c_y_y, c_z_z, c_ty_ty, c_tz_tz

--limits, one row for each change of an alarm:
  time_s,alarm,event,value,limit,unit
  raised; worse, raised again since its level has grown; or cleared. Its level then, and the limit, or
  the level that ends it, in the unit of [monitor.alarm]. Each alarm is acknowledged at once
and one for each change in the board's report of the probes, every second: `preload` or `probe NAME` is the alarm,
  the state of the spindle or of the probe the event, preload or gain the value

Files are written beside their places, as X.*.part, and moved there when they are complete: not where
the exit status is 1 or 2. A signal (Ctrl-C) removes them, and a later run what a killed one has left.

Exit status: 0, also if rows have no answer (a line on standard error counts them);
2 if the arguments, the design or the recording are at fault, or no row of it can be read;
1 if the results cannot be written.";
