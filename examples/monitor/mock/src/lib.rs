//! Mocks for tests of a board and of the monitor's laws: a flash that fails, cuts, a host at the monitor's link.
//!
//! | module | has |
//! | --- | --- |
//! | [`flash`] | flash in memory that fails as real ones do |
//! | [`rig`] | a monitor, a host at its link, and laws that hold in every tick |
//! | [`cuts`] | loads of teeth and ramps |

pub mod cuts;
pub mod flash;
pub mod rig;
