//! A spindle as a drawing in section: shaft with its diameters, rows with contact lines, supports, loads, noses and probes over an
//! axis in mm.

use solvers::dispatch::Precision;
use solvers::{Balls, with_solver};
use spindle_bearing::{FreeContact, Preload, Section, ShaftLoad, Support};
use spindle_file::designs::{DesignFile, short};
use spindle_file::plan::{Plan, Question, Row};
use spindle_file::probes::Probe;
use spindle_file::spindles::SpindleFile;

const WIDTH: f64 = 1000.0;
const MARGIN: f64 = 60.0;
/// Height of heading and loads above the drawing, of a line of text, and largest one of the drawing itself.
const TOP: f64 = 116.0;
const LINE: f64 = 18.0;
const HIGHEST: f64 = 460.0;
/// Half width of a bearing over the diameter of its balls, about.
const WIDE: f64 = 0.87;

const STYLE: &str = "text { font: 13px sans-serif; fill: #252B33 } .title { font: bold 18px sans-serif } \
    .mark { font-size: 12px; text-anchor: middle } .line { stroke: #252B33; fill: none } \
    .shaft { fill: #C9D1DB; stroke: #252B33 } .rigid { fill: #E8ECF1; stroke: #6B7684; stroke-dasharray: 6 4 } \
    .ring { fill: #8FA3B8; stroke: #252B33 } .ball { fill: #F7F8FA; stroke: #252B33 } \
    .contact { stroke: #D55E00; stroke-width: 1.6 } .axis { stroke: #6B7684; stroke-dasharray: 12 3 2 3 } \
    .support { stroke: #008060; fill: none } .spring { stroke: #9B3F83; fill: none; stroke-width: 1.6 } \
    .load { stroke: #005A9C; fill: #005A9C; stroke-width: 1.6 } .nose { stroke: #9B3F83; stroke-dasharray: 3 3 } \
    .record { stroke: #B07A00; fill: #B07A00; stroke-width: 1.6 } \
    .size { font-size: 11px; text-anchor: middle; dominant-baseline: central } \
    .probe { stroke: #C2185B; fill: #C2185B; stroke-width: 1.6 }";

/// Width of a section, in the picture, that has room for its diameters, and sections in a line of words.
const SIZE: f64 = 12.0;
const IN_LINE: usize = 4;

/// A point of the picture.
type Point = (f64, f64);

/// From metres to the picture, in one scale along and across the axis.
struct Sheet {
    svg: String,
    scale: f64,
    /// Position at the left margin, m, and height of the axis.
    left: f64,
    axis: f64,
}

impl Sheet {
    fn x(&self, x: f64) -> f64 {
        MARGIN + self.scale * (x - self.left)
    }

    /// Height of a point at this distance from the axis, m; positive above it.
    fn y(&self, y: f64) -> f64 {
        self.axis - self.scale * y
    }

    /// A ring in section, between two positions and two radii, m.
    fn ring(&mut self, class: &str, [from, to]: [f64; 2], [inner, outer]: [f64; 2]) {
        let (x, width, height) = (self.x(from), to - from, outer - inner);
        let (width, height) = (self.scale * width, self.scale * height);
        for y in [self.y(outer), self.y(-inner)] {
            self.svg += &format!(
                "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>\n"
            );
        }
    }

    fn line(&mut self, class: &str, points: &[Point]) {
        let points = points.iter().map(|(x, y)| format!("{x:.1},{y:.1} "));
        let points: String = points.collect();
        self.svg += &format!("<polyline class=\"{class}\" points=\"{points}\"/>\n");
    }

    fn arrow(&mut self, class: &str, from: Point, to: Point) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let part = 9.0 / dx.hypot(dy);
        let side = |s: f64| (to.0 - part * (dx + s * dy), to.1 - part * (dy - s * dx));
        self.line(class, &[from, to, side(0.4), side(-0.4), to]);
    }

    /// A spring as a zigzag.
    fn spring(&mut self, class: &str, from: Point, to: Point) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let points = [0.0, 4.0, 0.0, -4.0, 0.0, 4.0, 0.0, -4.0, 0.0].into_iter();
        let points = points.enumerate().map(|(i, across)| {
            let (along, across) = (i as f64 / 8.0, across / dx.hypot(dy));
            let (x, y) = (along * dx - across * dy, along * dy + across * dx);
            (from.0 + x, from.1 + y)
        });
        self.line(class, &points.collect::<Vec<_>>());
    }

    /// The housing: hatched on the side away from the axis.
    fn housing(&mut self, [from, to]: [f64; 2], y: f64, away: f64) {
        self.line("support", &[(from, y), (to, y)]);
        for i in 0..((to - from) / 6.0) as u32 {
            let x = from + 6.0 * f64::from(i);
            self.line("support", &[(x, y), (x + 5.0, y + 6.0 * away)]);
        }
    }

    fn text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.svg += &format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{text}</text>\n");
    }

    /// The row with its contact lines down to the axis, and what holds its outer ring.
    fn row(&mut self, row: &Row, [bore, outside]: [f64; 2], support: &Support<f64>) {
        let (pitch, ball) = (0.5 * row.design.pitch_diameter, row.design.ball_diameter);
        let ends = [-WIDE, WIDE].map(|side| row.position + side * ball);
        self.ring("ring", ends, [bore, pitch - 0.2 * ball]);
        self.ring("ring", ends, [pitch + 0.2 * ball, outside]);
        let [left, right] = ends.map(|end| self.x(end));
        let (x, radius) = (self.x(row.position), 0.5 * self.scale * ball);
        let sign = row.facing.sign::<f64>();
        let lean = sign * contact_angle(row).tan();
        for side in [1.0, -1.0] {
            let (y, edge) = (self.y(side * pitch), self.y(side * outside));
            self.svg += &format!(
                "<circle class=\"ball\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>\n"
            );
            // The outer contact is where the row faces, the inner one behind.
            let ends = [-pitch, 0.9 * ball];
            let xs = ends.map(|out| self.x(row.position + out * lean));
            let ys = ends.map(|out| self.y(side * (pitch + out)));
            self.line("contact", &[(xs[0], ys[0]), (xs[1], ys[1])]);
            if matches!(row.preload, Preload::Spring) {
                // It presses the outer ring against balls that the shaft presses where the row faces.
                let wall = (x + sign * (right - x), edge - 10.0 * side);
                let end = (x + sign * (left - x), wall.1);
                self.spring("spring", wall, end);
                self.line("spring", &[end, (end.0, edge)]);
                self.line("spring", &[(wall.0, wall.1 - 6.0), (wall.0, wall.1 + 6.0)]);
            } else if support.radial.is_finite() || support.axial.is_finite() {
                let wall = edge - 22.0 * side;
                self.spring("support", (x, edge), (x, wall));
                self.housing([left, right], wall, -side);
            } else {
                self.housing([left, right], edge, -side);
            }
        }
    }

    /// Arrows in the plane of x and y, which point at the shaft; a force along z in words.
    fn load(&mut self, load: &ShaftLoad<f64>, surface: f64) {
        let (x, [fx, fy, fz, ..]) = (self.x(load.position), load.load);
        if fx != 0.0 {
            self.arrow("load", (x - 50.0 * fx.signum(), self.axis), (x, self.axis));
        }
        if fy != 0.0 {
            let y = self.y(-surface * fy.signum());
            self.arrow("load", (x, y + 44.0 * fy.signum()), (x, y));
        }
        if fz != 0.0 {
            let text = if fz > 0.0 { "Fz > 0" } else { "Fz < 0" };
            self.text("mark", x, self.axis - 6.0, text);
        }
    }

    /// A section of the shaft, its diameters across.
    fn section(&mut self, of: &Section) {
        let radii = [0.5 * of.inner, 0.5 * of.outer];
        self.ring("shaft", [of.from, of.to], radii);
        if self.scale * (of.to - of.from) < SIZE {
            return;
        }
        let (x, y) = (
            self.x(0.5 * (of.from + of.to)),
            self.y(-0.5 * (radii[0] + radii[1])),
        );
        self.svg += &format!(
            "<text class=\"size\" transform=\"translate({x:.1} {y:.1}) rotate(-90)\">{}</text>\n",
            diameters(of)
        );
    }

    /// A probe as an arrow at the surface, from above or below where it sees y; along the axis from the nearer end of `ends`.
    fn probe(&mut self, probe: &Probe, surface: f64, ends: [f64; 2]) {
        let (x, [axial, up, _]) = (self.x(probe.position), probe.direction);
        let side = if up < -1e-6 { -1.0 } else { 1.0 };
        let tip = self.y(side * surface);
        let (from, to) = if axial == 0.0 {
            ((x, tip - 30.0 * side), (x, tip))
        } else {
            let is_left = 2.0 * probe.position <= ends[0] + ends[1];
            let out = if is_left { -30.0 } else { 30.0 };
            let y = self.y(0.5 * surface);
            ((x + out, y), (x, y))
        };
        self.arrow("probe", from, to);
        let below = if side < 0.0 { 16.0 } else { -5.0 };
        self.text("mark", from.0, from.1 + below, &probe.name);
    }

    /// The axis in mm, at this height of the picture.
    fn ruler(&mut self, y: f64) {
        let end = WIDTH - MARGIN;
        self.line("line", &[(MARGIN, y), (end, y)]);
        self.text("", end + 10.0, y + 4.0, "x / mm");
        // Some ten steps of 1, 2 or 5.
        let wide = (end - MARGIN) / self.scale;
        let power = 10_f64.powf((wide / 12.0).log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|part| part * power);
        let step = steps.into_iter().find(|step| wide <= 12.0 * step);
        let step = step.unwrap_or(wide);
        for i in 0..=12 {
            let at = step * ((self.left / step - 1e-6).ceil() + f64::from(i));
            let x = self.x(at);
            if x <= end + 1.0 {
                self.line("line", &[(x, y), (x, y + 6.0)]);
                self.text("mark", x, y + 20.0, &mm(at));
            }
        }
    }
}

/// A length in mm.
fn mm(x: f64) -> String {
    short(1e3 * x).to_string()
}

/// Free contact angle, rad.
fn contact_angle(row: &Row) -> f64 {
    let design = &row.design;
    let grooves = design.inner_groove_factor + design.outer_groove_factor - 1.0;
    match design.free_contact {
        FreeContact::Angle(angle) => angle,
        FreeContact::DiametralClearance(clearance) => {
            let play = clearance / (2.0 * grooves * design.ball_diameter);
            (1.0 - play).clamp(0.0, 1.0).acos()
        }
    }
}

/// Diameters of a section, mm.
fn diameters(of: &Section) -> String {
    match of.inner {
        0.0 => format!("Ø{}", mm(of.outer)),
        inner => format!("Ø{}/{}", mm(of.outer), mm(inner)),
    }
}

/// Preload of each row of a spindle with a mounted preload, at rest, cold, without loads; none if it cannot be built.
fn mounted(file: &SpindleFile) -> Option<Vec<f64>> {
    let mut plan = file.plan.clone();
    let (_, growth) = plan.mounted_preload.as_ref()?;
    let question = Question {
        growth: growth.clone(),
        ..Question::default()
    };
    if let Some(shaft) = &mut plan.shaft {
        shaft.loads.clear();
    }
    let solved = with_solver(&plan, Balls::Static, Precision::F64, |solver| {
        solver.solve(&question)
    });
    let answer = solved.ok()?.ok()?;
    Some(answer.rows.iter().map(|row| row.preload).collect())
}

/// The row of this number in words, with its part of a mounted preload.
fn words(
    i: usize,
    (row, of): (&Row, &DesignFile),
    support: &Support<f64>,
    plan: &Plan,
    part: Option<f64>,
) -> String {
    let held = match (row.preload, plan.spring, &plan.mounted_preload) {
        (Preload::Spring, force, _) => format!("spring {} N", force.unwrap_or_default()),
        (.., Some((force, _))) => match part {
            Some(part) => format!("{part:.0} N of the mounted preload"),
            None => format!("mounted preload of all rows {force} N"),
        },
        (Preload::Force(force), ..) => format!("preload {force} N"),
        (Preload::Closure(e), ..) => format!("closure {} µm", short(1e6 * e)),
        _ => String::new(),
    };
    let (x, name, balls) = (mm(row.position), &of.name, row.balls);
    let (ball, facing) = (mm(row.design.ball_diameter), row.facing.name());
    let angle = short(contact_angle(row).to_degrees());
    let mut text = format!(
        "row {i}: x = {x} mm, {name}, {balls} balls of {ball} mm, {angle}°, faces {facing}, {held}"
    );
    for (name, stiffness) in [("axial", support.axial), ("radial", support.radial)] {
        if stiffness.is_finite() {
            text += &format!(", {name} {} N/µm", short(stiffness / 1e6));
        }
    }
    text
}

/// The drawing as SVG.
pub fn svg(file: &SpindleFile) -> String {
    let (plan, elastic) = (&file.plan, file.plan.shaft.as_ref());
    let sections = elastic.map_or(&[][..], |shaft| &shaft.sections);
    let constant = elastic.map_or_else(|| file.constant_loads(), |shaft| shaft.loads.clone());
    let (mut all, mut highest, mut seat) = (vec![file.loaded_at()], 0_f64, f64::INFINITY);
    let mut rows = Vec::new();
    for (row, of) in plan.rows.iter().zip(file.designs()) {
        let (pitch, ball) = (0.5 * row.design.pitch_diameter, row.design.ball_diameter);
        let [bore, outside] = of.size_mm.map(|said| said.map(|mm| mm / 2e3));
        let bore = bore.unwrap_or(pitch - 0.9 * ball);
        let outside = outside.unwrap_or(pitch + 0.9 * ball);
        (highest, seat) = (highest.max(outside), seat.min(bore));
        all.extend([-WIDE, WIDE].map(|side| row.position + side * ball));
        rows.push((row, of, [bore, outside]));
    }
    for section in sections {
        highest = highest.max(0.5 * section.outer);
        all.extend([section.from, section.to]);
    }
    all.extend(file.noses.iter().map(|nose| nose.end.position));
    all.extend(constant.iter().map(|load| load.position));
    all.extend(file.probes.iter().map(|probe| probe.position));
    all.sort_by(f64::total_cmp);
    let ends = [all[0], all[all.len() - 1]];
    let wide = WIDTH - 2.0 * MARGIN;
    let scale = (wide / (ends[1] - ends[0])).min(0.5 * HIGHEST / highest);
    let mut sheet = Sheet {
        svg: String::new(),
        scale,
        // In the middle, if it is higher than long.
        left: 0.5 * (ends[0] + ends[1] - wide / scale),
        axis: TOP + scale * highest,
    };
    if sections.is_empty() {
        sheet.ring("rigid", ends, [0.0, seat]);
    }
    for of in sections {
        sheet.section(of);
    }
    let surface = |x: f64| {
        let at = sections.iter().filter(|of| of.from <= x && x <= of.to);
        at.map(|of| 0.5 * of.outer).reduce(f64::max).unwrap_or(seat)
    };
    let mounted = mounted(file).unwrap_or_default();
    let axis = sheet.axis;
    sheet.line("axis", &[(24.0, axis), (WIDTH - 24.0, axis)]);
    let (mut told, bottom) = (Vec::new(), sheet.y(-highest) + 34.0);
    for (i, (row, of, radii)) in rows.into_iter().enumerate() {
        let support = elastic.and_then(|shaft| shaft.supports.get(i));
        let support = support.unwrap_or(&Support::RIGID);
        sheet.row(row, radii, support);
        let (x, y) = (sheet.x(row.position), sheet.y(radii[1]) - 32.0);
        sheet.text("mark", x, y, &i.to_string());
        told.push(words(i, (row, of), support, plan, mounted.get(i).copied()));
    }
    for load in &constant {
        let (x, [fx, fy, fz, ..]) = (load.position, load.load);
        sheet.load(load, surface(x));
        let forces = format!("Fx = {fx} N, Fy = {fy} N, Fz = {fz} N");
        told.push(format!("constant load: x = {} mm, {forces}", mm(x)));
    }
    for nose in &file.noses {
        let x = sheet.x(nose.end.position);
        sheet.line("nose", &[(x, 72.0), (x, bottom)]);
        sheet.text("mark", x, 66.0, &nose.name);
        told.push(format!("{}: x = {} mm", nose.name, mm(nose.end.position)));
    }
    for probe in &file.probes {
        let (name, x, [axial, up, aside]) = (&probe.name, probe.position, probe.direction);
        sheet.probe(probe, surface(x), ends);
        let angle = short(aside.atan2(up).to_degrees());
        let sees = match axial {
            0.0 => format!("{angle}° from +y towards +z"),
            _ => "along x".to_owned(),
        };
        told.push(format!("probe {name}: x = {} mm, {sees}", mm(x)));
    }
    for (i, some) in sections.chunks(IN_LINE).enumerate() {
        let some = some
            .iter()
            .map(|of| format!("{} to {} {}", mm(of.from), mm(of.to), diameters(of)));
        let start = if i == 0 { "sections, mm: " } else { "" };
        told.push(format!("{start}{}", some.collect::<Vec<_>>().join("; ")));
    }
    let (x, at) = (sheet.x(file.loaded_at()), mm(file.loaded_at()));
    sheet.arrow("record", (x, axis - 46.0), (x, axis - 3.0));
    sheet.arrow("record", (x - 46.0, axis), (x - 3.0, axis));
    told.push(format!("recorded loads (arrows to the axis): x = {at} mm"));
    sheet.ruler(bottom);
    for (i, line) in told.iter().enumerate() {
        sheet.text("", MARGIN, bottom + 34.0 + LINE * (i + 1) as f64, line);
    }
    sheet.text("title", MARGIN, 30.0, &file.name);
    let height = bottom + 56.0 + LINE * told.len() as f64;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\">\n<style>{STYLE}</style>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#F7F8FA\"/>\n{}</svg>\n",
        sheet.svg
    )
}
