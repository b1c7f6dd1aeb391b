//! A case: values by the names of columns.

use std::collections::BTreeMap;

/// Values by the names of their columns, SI but for the units in the names.
pub type Case = BTreeMap<String, f64>;

/// The case with these columns as well.
pub fn with<const N: usize>(mut case: Case, columns: [&str; N], values: [f64; N]) -> Case {
    case.extend(columns.map(str::to_owned).into_iter().zip(values));
    case
}

/// The case with the elements of a matrix as well, `name_x_x` to `name_tz_tz`.
pub fn with_matrix(mut case: Case, name: &str, matrix: [[f64; 5]; 5]) -> Case {
    let freedoms = ["x", "y", "z", "ty", "tz"];
    for (row, values) in freedoms.iter().zip(matrix) {
        let columns = freedoms.map(|column| format!("{name}_{row}_{column}"));
        case.extend(columns.into_iter().zip(values));
    }
    case
}
