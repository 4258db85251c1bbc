//! What the parameters of a lens are called.

use rcs_calibration::Parameter;

/// The key in `report.yaml`.
pub(super) const fn key(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Fx => "fx",
        Parameter::Fy => "fy",
        Parameter::Cx => "cx",
        Parameter::Cy => "cy",
        Parameter::K1 => "k1",
        Parameter::K2 => "k2",
        Parameter::P1 => "p1",
        Parameter::P2 => "p2",
        Parameter::K3 => "k3",
    }
}

/// What it is.
pub(super) const fn meaning(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Fx => "focal length along u",
        Parameter::Fy => "focal length along v",
        Parameter::Cx => "principal point, u",
        Parameter::Cy => "principal point, v",
        Parameter::K1 | Parameter::K2 | Parameter::K3 => "radial distortion",
        Parameter::P1 | Parameter::P2 => "tangential distortion",
    }
}

/// Its unit; distortion has none.
pub(super) const fn unit(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Fx | Parameter::Fy | Parameter::Cx | Parameter::Cy => "px",
        _ => "",
    }
}
