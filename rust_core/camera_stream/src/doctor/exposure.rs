//! Checks whether the calibration camera's exposure is locked, by the dynamic_reconfigure parameters of its driver.
//!
//! Drivers keep these values as parameters: openni2_camera and libuvc_camera `auto_exposure`, realsense2_camera
//! `enable_auto_exposure`, usb_cam `autoexposure`, FLIR's and Basler's `exposure_auto`.

use rcs_ros::ParameterValue;

use super::finding::Finding;
use super::look::Look;

/// Last parts of the parameters' names, in lower case.
const NAMES: [&str; 8] = [
    "auto_exposure",
    "autoexposure",
    "auto_exposure_mode",
    "color_auto_exposure",
    "rgb_auto_exposure",
    "enable_auto_exposure",
    "exposure_auto",
    "exposureauto",
];
/// Parts of the names of cameras that a calibration does not look through.
const NO_COLOR_CAMERAS: [&str; 3] = ["stereo_module", "depth", "ir"];

/// One finding for each driver that has the parameter.
pub(super) fn all(look: &Look<'_>) -> Vec<Finding> {
    let ros = &look.session.ros;
    let names = ros.parameter_names().into_iter().filter(|name| is_exposure(name));
    let findings: Vec<Finding> = names.filter_map(|name| Some(finding(&name, &ros.parameter(&name)?))).collect();
    if findings.is_empty() {
        let text = "no camera driver has a parameter of it";
        return vec![Finding::unknown("exposure", text, "lock the calibration camera's exposure before a scan")];
    }
    findings
}

/// `true` for the parameter of a colour camera's automatic exposure.
fn is_exposure(name: &str) -> bool {
    let parts: Vec<&str> = name.split('/').collect();
    let is_named = parts.last().is_some_and(|last| NAMES.contains(&last.to_ascii_lowercase().as_str()));
    is_named && !parts.iter().any(|part| NO_COLOR_CAMERAS.contains(part))
}

/// The finding for a parameter's value.
fn finding(name: &str, value: &ParameterValue) -> Finding {
    let (node, parameter) = name.rsplit_once('/').unwrap_or_default();
    let text = format!("{name} is {value}");
    let is_on = match value {
        ParameterValue::Bool(is_on) => Some(*is_on),
        ParameterValue::String(text) => match text.to_ascii_lowercase().as_str() {
            "off" | "manual" | "false" => Some(false),
            "continuous" | "once" | "auto" | "on" | "true" => Some(true),
            _ => None,
        },
        _ => None,
    };
    match is_on {
        Some(false) => Finding::good("exposure", format!("locked: {text}")),
        Some(true) => {
            let off = if matches!(value, ParameterValue::Bool(_)) { "false" } else { "Off" };
            let advice =
                format!("lock it before a scan: rosrun dynamic_reconfigure dynparam set {node} {parameter} {off}");
            Finding::bad("exposure", format!("automatic: {text}"), advice)
        }
        None => Finding::unknown("exposure", text, "see in its driver's documentation whether that locks it"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_exposure_is_a_fault_with_the_command_that_locks_it() {
        let line = |name: &str, value: ParameterValue| finding(name, &value).to_string();
        assert_eq!(
            line("/head_camera/driver/auto_exposure", ParameterValue::Bool(true)),
            "✗ exposure: automatic: /head_camera/driver/auto_exposure is true; lock it before a scan: rosrun \
             dynamic_reconfigure dynparam set /head_camera/driver auto_exposure false"
        );
        assert!(line("/c/auto_exposure", ParameterValue::Bool(false)).starts_with("✓ exposure: locked: "));
        assert!(line("/c/exposure_auto", "Continuous".into()).ends_with("dynparam set /c exposure_auto Off"));
        assert!(line("/c/exposure_auto", "Off".into()).starts_with('✓'));
        assert!(line("/c/auto_exposure", ParameterValue::Int(3)).starts_with("? exposure: /c/auto_exposure is 3; "));
    }

    #[test]
    fn only_colour_cameras_count() {
        for name in ["/head_camera/driver/auto_exposure", "/camera/rgb_camera/enable_auto_exposure", "/c/ExposureAuto"]
        {
            assert!(is_exposure(name), "{name}");
        }
        for name in
            ["/camera/stereo_module/enable_auto_exposure", "/ir/auto_exposure", "/c/auto_exposure/x", "/exposure"]
        {
            assert!(!is_exposure(name), "{name}");
        }
    }
}
