//! Projector files of other calibrators, converted to this project's keys.
//!
//! | tool | the projector's matrix, distortion | its size |
//! |---|---|---|
//! | procam-calibration (XML), and relatives (JSON) | `proj_int`, `proj_dist` | `proj_shape` (rows, columns), if any |
//! | scan3d-capture of Moreno and Taubin (YAML) | `proj_K`, `proj_kc` | |
//! | the same, as a MATLAB script | `fc_right`, `cc_right`, `kc_right` | |
//! | SLStudio (XML, YAML) | `Kp`, `kp` | `screenResX`, `screenResY` |
//! | mapamok, ofxCv (YAML, XML) | `cameraMatrix`, `distCoeffs` | `imageSize`, or with `_width`, `_height` |
//! | OpenCV up to 2.4 (YAML, XML) | `Camera_Matrix`, `Distortion_Coefficients` | `image_Width`, `image_Height` |
//! | Bouguet's toolbox (`Calib_Results.m`) | `fc`, `cc`, `alpha_c`, `kc` | `nx`, `ny` |
//! | Kalibr (YAML, of one camera) | `intrinsics`, `distortion_coeffs` | `resolution` |
//! | camera_calibration_parsers (INI), `ost.txt` | `camera matrix`, `distortion`, `projection` | `width`, `height` |
//!
//! Poses are not read: they are relative to the tool's own camera. `width`, `height`, `frame_id`, `camera_info_topic`
//! and `frames` may be added to these files.

use serde_yaml_ng::{Mapping, Value};

use super::key_error::KeyError;
use super::own_form::{numbers_of, own_form, whole_of};
use super::{ini, kalibr, matlab, opencv_xml};

/// Keys of this project's two forms, which exclude other tools' keys.
const OWN_MATRICES: [&str; 6] = ["K", "P", "k", "p", "camera_matrix", "projection_matrix"];

/// Keys of a tool for the projector.
struct Tool {
    name: &'static str,
    matrix: &'static str,
    distortion: &'static str,
    /// Width and height; or the width alone, with both in a list.
    size: [&'static str; 2],
}

const TOOLS: [Tool; 5] = [
    Tool { name: "procam-calibration", matrix: "proj_int", distortion: "proj_dist", size: ["", ""] },
    Tool { name: "scan3d-capture", matrix: "proj_K", distortion: "proj_kc", size: ["", ""] },
    Tool { name: "SLStudio", matrix: "Kp", distortion: "kp", size: ["screenResX", "screenResY"] },
    Tool {
        name: "mapamok or ofxCv",
        matrix: "cameraMatrix",
        distortion: "distCoeffs",
        size: ["imageSize_width", "imageSize_height"],
    },
    Tool {
        name: "OpenCV's sample",
        matrix: "Camera_Matrix",
        distortion: "Distortion_Coefficients",
        size: ["image_Width", "image_Height"],
    },
];

/// Values of another tool's file by this project's keys; `None` for a file of this project.
///
/// # Errors
/// The missing key, or the tool that seems to have written the file.
pub(super) fn values(text: &str) -> Result<Option<Value>, KeyError> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let of_file = |reason| ("the file", reason);
    if text.starts_with('<') {
        let values = opencv_xml::values(text).map_err(of_file)?;
        return by_own_keys(&values).map(|own| Some(own.unwrap_or(values).into()));
    }
    if ini::is_ini(text) {
        return ini::values(text).map(|values| Some(values.into()));
    }
    let document = serde_yaml_ng::Deserializer::from_str(text).next().map(serde::Deserialize::deserialize);
    let Some(Ok(Value::Mapping(values))) = document else {
        // What is neither gets its error from the reader of this project's files, with a line.
        return matlab::values(text).map(|values| values.map(Value::from));
    };
    by_own_keys(&values).map(|own| own.map(Value::from))
}

/// The values by this project's keys, unless they are already.
fn by_own_keys(values: &Mapping) -> Result<Option<Mapping>, KeyError> {
    if OWN_MATRICES.iter().any(|key| values.contains_key(key)) {
        return Ok(None);
    }
    let adopted = match adopted(values)? {
        None => kalibr::values(values)?,
        adopted => adopted,
    };
    if adopted.is_some() {
        return Ok(adopted);
    }
    match foreign_keys(values) {
        Some(what) => Err(("the file", format!("it seems to be {what}"))),
        None => Ok(None),
    }
}

/// The values of a file with a tool's keys.
fn adopted(values: &Mapping) -> Result<Option<Mapping>, KeyError> {
    let Some(tool) = TOOLS.iter().find(|tool| values.contains_key(tool.matrix)) else { return Ok(None) };
    let k = numbers_of(values, tool.matrix).ok_or_else(|| (tool.matrix, "it is no matrix of numbers".to_owned()))?;
    let d = match values.get(tool.distortion) {
        Some(_) => numbers_of(values, tool.distortion)
            .ok_or_else(|| (tool.distortion, "it is no list of numbers".to_owned()))?,
        None => Vec::new(),
    };
    let size = whole_of(values, tool.size[0]).zip(whole_of(values, tool.size[1]));
    let size = size.or_else(|| match *numbers_of(values, "imageSize")? {
        [width, height] => Some((width.into(), height.into())),
        _ => None,
    });
    let size = size.or_else(|| match *numbers_of(values, "proj_shape")? {
        [height, width] => Some((width.into(), height.into())),
        _ => None,
    });
    own_form(values, tool.name, k, d, size).map(Some)
}

/// Name of an unsupported format by its keys.
fn foreign_keys(values: &Mapping) -> Option<&'static str> {
    let has = |key: &str| values.contains_key(key);
    if has("M1") && has("M2") {
        return Some(
            "OpenCV's stereo_calib, which does not say which of both is the projector: write its matrix as \
                     camera_matrix and its distortion as distortion_coefficients, with image_width and image_height",
        );
    }
    if has("cam_int") || has("cam_K") || has("camera") {
        return Some("a calibration of a camera only: the projector's matrix (proj_int, proj_K) is missing");
    }
    None
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rcs_messages::sensor_msgs::CameraInfo;

    use crate::projector::ProjectorFile;
    use crate::FileError;

    const K: [f64; 9] = [3953.5, 0.0, 737.25, 0.0, 3893.0, 1357.5, 0.0, 0.0, 1.0];
    const D: [f64; 5] = [-0.017, -0.44, -0.0094, -0.0213, 1.7];
    const KEYS: &str = "width: 1024\nheight: 768\nframe_id: beamer\n";

    fn parse(text: &str) -> Result<ProjectorFile, FileError> {
        ProjectorFile::parse(Path::new("calibration"), text)
    }

    fn error(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    fn words(numbers: &[f64]) -> String {
        // As OpenCV writes them, over several lines.
        numbers.iter().map(|number| format!("{number:e}")).collect::<Vec<_>>().join("\n    ")
    }

    fn xml_matrix(name: &str, [rows, cols]: [usize; 2], numbers: &[f64]) -> String {
        format!(
            "<{name} type_id=\"opencv-matrix\">\n  <rows>{rows}</rows>\n  <cols>{cols}</cols>\n  <dt>d</dt>\n  <data>\n    \
             {}</data></{name}>\n",
            words(numbers)
        )
    }

    fn xml(elements: &str) -> String {
        format!("<?xml version=\"1.0\"?>\n<opencv_storage>\n{elements}</opencv_storage>\n")
    }

    fn yaml_matrix(name: &str, [rows, cols]: [usize; 2], numbers: &[f64]) -> String {
        let numbers = numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(", ");
        format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {numbers} ]\n")
    }

    fn assert_projector(info: &CameraInfo) {
        assert_eq!((info.width, info.height), (1024, 768));
        assert_eq!((info.K, info.D.as_slice()), (K, &D[..]));
        assert_eq!(info.P, [K[0], 0.0, K[2], 0.0, 0.0, K[4], K[5], 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(info.distortion_model, "plumb_bob");
        assert_eq!(info.R, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], "no tool's pose is taken for it");
    }

    /// A file with these keys for the projector in both of OpenCV's forms, and the camera's and the pose's beside them.
    fn both_forms(matrix: &str, distortion: &str, [camera, camera_distortion]: [&str; 2], size: &str) -> [String; 2] {
        let camera_k = [3452.0, 0.0, 587.0, 0.0, 3449.0, 521.0, 0.0, 0.0, 1.0];
        let parts = [
            (camera, [3, 3], &camera_k[..]),
            (camera_distortion, [1, 5], &[0.1, 0.2, 0.3, 0.4, 0.5]),
            (matrix, [3, 3], &K),
            (distortion, [1, 5], &D),
            ("R", [3, 3], &[0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
            ("T", [3, 1], &[85.7, -630.4, -100.8]),
        ];
        let parts = || parts.iter().filter(|(name, ..)| !name.is_empty());
        let elements: String = parts().map(|(name, shape, numbers)| xml_matrix(name, *shape, numbers)).collect();
        let entries: String = parts().map(|(name, shape, numbers)| yaml_matrix(name, *shape, numbers)).collect();
        let sizes = size.split_terminator('\n').map(|line| line.split_once(": ").unwrap());
        let sizes: String = sizes
            .map(|(key, value)| format!("<{key}>{}</{key}>\n", value.trim_matches(['[', ']']).replace(',', "")))
            .collect();
        [xml(&(elements + &sizes + "<rms>8.5e-01</rms>\n")), format!("%YAML:1.0\n---\n{entries}{size}rms: 8.5e-01\n")]
    }

    #[test]
    fn the_projectors_part_of_each_tools_file_is_read_in_each_form() {
        let opencv = "image_Width: 1024\nimage_Height: 768\n";
        let of_cv = "imageSize_width: 1024\nimageSize_height: 768\n";
        for files in [
            both_forms("proj_int", "proj_dist", ["cam_int", "cam_dist"], KEYS),
            both_forms("proj_int", "proj_dist", ["cam_int", "cam_dist"], "proj_shape: [768, 1024]\n"),
            both_forms("proj_K", "proj_kc", ["cam_K", "cam_kc"], KEYS),
            both_forms("Kp", "kp", ["Kc", "kc"], "screenResX: 1024\nscreenResY: 768\n"),
            both_forms("cameraMatrix", "distCoeffs", ["", ""], of_cv),
            both_forms("cameraMatrix", "distCoeffs", ["", ""], "imageSize: [1024, 768]\n"),
            both_forms("Camera_Matrix", "Distortion_Coefficients", ["", ""], opencv),
        ] {
            for text in files {
                let file = parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
                assert_projector(&file.camera_info);
                assert!(file.warnings().is_empty(), "{:?}", file.warnings());
                assert_eq!(file.camera_info.header.frame_id == "beamer", text.contains("beamer"));
                file.lens().unwrap();
            }
        }
    }

    #[test]
    fn the_json_of_a_relative_is_read_with_its_tabs() {
        let matrix = |rows: usize, cols: usize, numbers: &[f64]| {
            format!(
                "{{\n\t\t\"type_id\": \"opencv-matrix\",\n\t\t\"rows\" : {rows},\n\t\t\"cols\" : {cols},\n\t\t\"dt\" : \
                 \"d\",\n\t\t\"data\" : {numbers:?}\n\t}}"
            )
        };
        let text = format!(
            "{{\n\t\"proj_int\": {},\n\t\"proj_dist\": {},\n\t\"proj_shape\": {}\n}}\n",
            matrix(3, 3, &K),
            matrix(1, 5, &D),
            matrix(2, 1, &[768.0, 1024.0])
        );
        assert_projector(&parse(&text).unwrap().camera_info);
    }

    #[test]
    fn opencvs_own_xml_is_read_as_its_yaml() {
        let elements =
            "<image_width>1024</image_width>\n<image_height>768</image_height>\n<fisheye_model>0</fisheye_model>\n"
                .to_owned()
                + &xml_matrix("camera_matrix", [3, 3], &K)
                + &xml_matrix("distortion_coefficients", [5, 1], &D);
        assert_projector(&parse(&xml(&elements)).unwrap().camera_info);
        let fisheye = xml(&elements.replace(">0</fish", ">1</fish").replace("1.7e0", ""));
        let info = parse(&fisheye).unwrap().camera_info;
        assert_eq!((info.distortion_model.as_str(), info.D.len()), ("equidistant", 4));
    }

    #[test]
    fn matlab_scripts_of_two_toolboxes_are_read() {
        let two = "% Intrinsic parameters of camera:\nfc_left = [ 3452.0 3449.0 ]; % Focal Length\ncc_left = [ 587 521 ];\n\
                   kc_left = [ 0 0 0 0 0 ];\nfc_right = [ 3953.5 3893.0 ]; % Focal = Length\ncc_right = [ 737.25 1357.5 ];\n\
                   alpha_c_right = [ 0.000000 ]; % Skew\nkc_right = [ -0.017 -0.44 -0.0094 -0.0213 1.7 ];\n\
                   om = [ 0 0 0 ];\nT = [ 1 2 3 ];\n";
        assert_projector(&parse(&format!("{two}width = 1024; height = 768;\n")).unwrap().camera_info);
        assert!(error(two).ends_with(
            "width: missing: scan3d-capture does not write the projector's size; add width and \
                                      height in pixels"
        ));
        let skewed = two.replace("0.000000", "2.5");
        assert!(error(&skewed).contains("alpha_c_right: it is 2.5"), "{}", error(&skewed));
        let one = "fc = [ 3953.5 ; 3893.0 ];\ncc = [ 737.25 ; 1357.5 ];\nalpha_c = 0.5;\n\
                   kc = [ -0.017 ; -0.44 ; -0.0094 ; -0.0213 ; 1.7 ];\nnx = 1024;\nny = 768;\nactive_images = ones(1,3);\n";
        let info = parse(one).unwrap().camera_info;
        assert_eq!((info.K[1], info.K[0], info.K[5], info.width), (1976.75, 3953.5, 1357.5, 1024));
    }

    #[test]
    fn other_tools_keys_do_not_count_beside_this_projects_own() {
        let own = "width: 4\nheight: 3\nK: [5, 0, 2, 0, 6, 1, 0, 0, 1]\n# fc = [ 1 2 ]; cc = [ 1 2 ];\ncamera: front\nKp: 1\n";
        let file = parse(own).unwrap();
        assert_eq!(
            (file.camera_info.K[0], file.ignored_keys.as_slice()),
            (5.0, &["camera".to_owned(), "Kp".to_owned()][..])
        );
    }

    #[test]
    fn what_is_missing_is_named_with_the_tool() {
        for text in both_forms("proj_int", "proj_dist", ["cam_int", "cam_dist"], "") {
            assert_eq!(
                error(&text),
                "calibration: width: missing: procam-calibration does not write the projector's size; add width and \
                 height in pixels"
            );
        }
        let broken = xml(&(xml_matrix("proj_K", [3, 3], &K[..6]) + "<width>1024</width><height>768</height>"));
        assert!(error(&broken).contains("6 numbers where 9"), "{}", error(&broken));
        let words = xml("<proj_K>\"none\"</proj_K><width>1024</width><height>768</height>");
        assert!(error(&words).contains("proj_K: it is no matrix of numbers"), "{}", error(&words));
        let infinite =
            xml(&(xml_matrix("Kp", [3, 3], &K).replace("1e0", ".Nan") + "<width>9</width><height>9</height>"));
        assert!(error(&infinite).contains("not a finite number"), "{}", error(&infinite));
    }

    #[test]
    fn what_cannot_be_read_says_what_it_seems_to_be() {
        for (text, expected) in [
            ("M1: [1]\nD1: [1]\nM2: [1]\nD2: [1]\n", "OpenCV's stereo_calib, which does not say which"),
            ("cam_K: [1]\ncam_kc: [1]\n", "a calibration of a camera only"),
            ("<opencv_storage><cam_int>1</cam_int></opencv_storage>", "a calibration of a camera only"),
            ("<?xml version=\"1.0\"?><ProjectorCameraEnsemble><name/></ProjectorCameraEnsemble>", "RoomAlive Toolkit"),
            ("<robot name=\"r\"/>", "it is XML, but <robot> where OpenCV writes <opencv_storage>"),
            ("<opencv_storage><a></opencv_storage>", "it is not XML as OpenCV writes it"),
        ] {
            let error = error(text);
            assert!(error.starts_with("calibration: the file: ") && error.contains(expected), "{error}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibration.mat");
        std::fs::write(&path, b"MATLAB 5.0 MAT-file\xff").unwrap();
        let error = ProjectorFile::read(&path).unwrap_err().to_string();
        assert!(error.contains("a MAT-file of MATLAB"), "{error}");
    }
}
