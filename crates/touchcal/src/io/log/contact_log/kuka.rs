//! How KUKA's Sunrise recorder (`DataRecorder`) names columns.

/// What its header begins with; fields are then separated by blanks.
pub(super) const HEADER: &[u8] = b"%";

/// The usual name of a recorder's column: `q1` for `axisQMsr_LBR_iiwa_14_R820_1[0]`, `fx` for
/// `cartForce1_X`, `tx` for `cartTorque1_TauX`.
pub(super) fn usual(column: &str) -> Option<String> {
    let column = column.trim();
    if let Some(joint) = column.strip_prefix("axisQMsr") {
        let index = joint.strip_suffix(']')?.rsplit_once('[')?.1;
        return Some(format!("q{}", index.parse::<u16>().ok()?.checked_add(1)?));
    }
    let component = |rest: &str, separator, letter: &str| {
        let (number, axis) = rest.split_once(separator)?;
        let known = number.bytes().all(|byte| byte.is_ascii_digit()) && matches!(axis, "X" | "Y" | "Z");
        known.then(|| format!("{letter}{}", axis.to_ascii_lowercase()))
    };
    match (column.strip_prefix("cartForce"), column.strip_prefix("cartTorque")) {
        (Some(rest), _) => component(rest, "_", "f"),
        (_, Some(rest)) => component(rest, "_Tau", "t"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::usual;

    #[test]
    fn the_recorders_names_are_known() {
        let name = |column| usual(column).unwrap_or_default();
        assert_eq!(name("axisQMsr_LBR_iiwa_14_R820_1[0]"), "q1");
        assert_eq!(name(" axisQMsr_LBR_iiwa_7_R800_1[6]"), "q7");
        assert_eq!([name("cartForce1_X"), name("cartForce1_Z"), name("cartTorque1_TauY")], ["fx", "fz", "ty"]);
        // Commanded positions, and variances.
        for other in [
            "axisQCmd_LBR_iiwa_14_R820_1[0]",
            "cartForceVar1_X",
            "cartForce1_W",
            "axisQMsr",
            "axisQMsr[-1]",
            "axisQMsr[65535",
            "q1",
        ] {
            assert_eq!(usual(other), None, "{other}");
        }
    }
}
