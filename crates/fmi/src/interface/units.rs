//! Units and declared real types of the variable table.

/// Base-unit exponents of a unit, FMI 2.0 `BaseUnit`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name, e.g. `N.m`.
    pub name: &'static str,
    /// Exponents of kg, m, s, A, rad: [`BASES`].
    pub exponents: [i32; 5],
    /// Display unit: name and factor from base to display.
    pub display: Option<(&'static str, f64)>,
}

/// A declared real type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealType {
    /// Name, e.g. `Angle`.
    pub name: &'static str,
    /// Quantity, e.g. `Angle`.
    pub quantity: &'static str,
    /// Unit by name in [`UNITS`].
    pub unit: &'static str,
}

/// Degrees per radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

const fn unit(name: &'static str, exponents: [i32; 5]) -> Unit {
    Unit { name, exponents, display: None }
}

const fn shown(name: &'static str, exponents: [i32; 5], display: &'static str, factor: f64) -> Unit {
    Unit { name, exponents, display: Some((display, factor)) }
}

const fn real(name: &'static str, quantity: &'static str, unit: &'static str) -> RealType {
    RealType { name, quantity, unit }
}

/// Base units of [`Unit::exponents`], as the FMI standard names them.
pub const BASES: [&str; 5] = ["kg", "m", "s", "A", "rad"];

/// Units that the table uses; exponents of kg, m, s, A, rad.
pub const UNITS: &[Unit] = &[
    unit("1", [0, 0, 0, 0, 0]),
    unit("s", [0, 0, 1, 0, 0]),
    unit("1/s", [0, 0, -1, 0, 0]),
    unit("m", [0, 1, 0, 0, 0]),
    unit("m/s", [0, 1, -1, 0, 0]),
    unit("m/s2", [0, 1, -2, 0, 0]),
    shown("rad", [0, 0, 0, 0, 1], "deg", DEGREES),
    shown("rad/s", [0, 0, -1, 0, 1], "deg/s", DEGREES),
    shown("rad/s2", [0, 0, -2, 0, 1], "deg/s2", DEGREES),
    unit("N", [1, 1, -2, 0, 0]),
    unit("N.m", [1, 2, -2, 0, 0]),
    unit("N.s", [1, 1, -1, 0, 0]),
    unit("N.m.s", [1, 2, -1, 0, 0]),
    unit("N/m", [1, 0, -2, 0, 0]),
    unit("N.s/m", [1, 0, -1, 0, 0]),
    unit("N.m/rad", [1, 2, -2, 0, -1]),
    unit("N.m.s/rad", [1, 2, -1, 0, -1]),
    unit("m2/s", [0, 2, -1, 0, 0]),
    unit("kg/m3", [1, -3, 0, 0, 0]),
    unit("J", [1, 2, -2, 0, 0]),
    unit("W", [1, 2, -3, 0, 0]),
    unit("V", [1, 2, -3, -1, 0]),
    unit("A", [0, 0, 0, 1, 0]),
    unit("A/s", [0, 0, -1, 1, 0]),
    unit("1/s2", [0, 0, -2, 0, 0]),
    unit("1/m", [0, -1, 0, 0, 0]),
    unit("1/(m.s)", [0, -1, -1, 0, 0]),
    unit("1/(m.s2)", [0, -1, -2, 0, 0]),
];

/// Real types that the table uses.
pub const TYPES: &[RealType] = &[
    real("Time", "Time", "s"),
    real("Ratio", "Ratio", "1"),
    real("Strain", "Strain", "1"),
    real("Position", "Length", "m"),
    real("Velocity", "Velocity", "m/s"),
    real("Acceleration", "Acceleration", "m/s2"),
    real("Angle", "Angle", "rad"),
    real("AngularVelocity", "AngularVelocity", "rad/s"),
    real("AngularAcceleration", "AngularAcceleration", "rad/s2"),
    real("Force", "Force", "N"),
    real("Moment", "Torque", "N.m"),
    real("AngularImpulse", "AngularImpulse", "N.m.s"),
    real("RotationalStiffness", "RotationalSpringConstant", "N.m/rad"),
    real("RotationalDamping", "RotationalDampingConstant", "N.m.s/rad"),
    real("Impulse", "Impulse", "N.s"),
    real("TranslationalStiffness", "TranslationalSpringConstant", "N/m"),
    real("TranslationalDamping", "TranslationalDampingConstant", "N.s/m"),
    real("DampingRate", "Frequency", "1/s"),
    real("Circulation", "Circulation", "m2/s"),
    real("Density", "Density", "kg/m3"),
    real("Energy", "Energy", "J"),
    real("Power", "Power", "W"),
    real("Voltage", "ElectricPotential", "V"),
    real("Current", "ElectricCurrent", "A"),
    real("CurrentSlope", "CurrentSlope", "A/s"),
    real("RatioRate", "RatioRate", "1/s"),
    real("RatioAcceleration", "RatioAcceleration", "1/s2"),
    real("StrainRate", "StrainRate", "1/s"),
    real("StrainAcceleration", "StrainAcceleration", "1/s2"),
    real("Curvature", "Curvature", "1/m"),
    real("CurvatureRate", "CurvatureRate", "1/(m.s)"),
    real("CurvatureAcceleration", "CurvatureAcceleration", "1/(m.s2)"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_names_a_unit_and_every_unit_is_used() {
        for declared in TYPES {
            assert!(UNITS.iter().any(|unit| unit.name == declared.unit), "{} has no unit", declared.name);
        }
        for unit in UNITS {
            assert!(TYPES.iter().any(|declared| declared.unit == unit.name), "no type uses {}", unit.name);
        }
    }
}
