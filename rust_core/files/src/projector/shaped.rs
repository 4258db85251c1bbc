//! Numbers in camera_calibration's form, `{rows, cols, data}`, or as the list alone.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::Deserialize;
use serde_yaml_ng::Value;

/// Numbers `T`, beside which numbers of rows and of columns may be given.
pub(super) struct Shaped<T, Rows, Cols> {
    pub(super) data: T,
    shape: PhantomData<(Rows, Cols)>,
}

#[derive(Deserialize)]
struct Keys<T, Rows, Cols> {
    #[serde(rename = "rows")]
    _rows: Option<Rows>,
    #[serde(rename = "cols")]
    _cols: Option<Cols>,
    #[serde(rename = "dt")]
    _dt: Option<Value>,
    data: T,
}

impl<'de, T, Rows, Cols> Deserialize<'de> for Shaped<T, Rows, Cols>
where
    T: Deserialize<'de>,
    Rows: Deserialize<'de>,
    Cols: Deserialize<'de>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let data = deserializer.deserialize_any(ShapedVisitor::<T, Rows, Cols>(PhantomData))?;
        Ok(Self { data, shape: PhantomData })
    }
}

struct ShapedVisitor<T, Rows, Cols>(PhantomData<(T, Rows, Cols)>);

impl<'de, T, Rows, Cols> Visitor<'de> for ShapedVisitor<T, Rows, Cols>
where
    T: Deserialize<'de>,
    Rows: Deserialize<'de>,
    Cols: Deserialize<'de>,
{
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{{rows, cols, data}} or a list of numbers")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        Keys::<T, Rows, Cols>::deserialize(MapAccessDeserializer::new(map)).map(|keys| keys.data)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<T, A::Error> {
        T::deserialize(SeqAccessDeserializer::new(list))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rcs_messages::sensor_msgs::CameraInfo;

    use crate::projector::ProjectorFile;

    fn parse(text: &str) -> Result<CameraInfo, String> {
        let text = format!("width: 64\nheight: 48\n{text}");
        ProjectorFile::parse(Path::new("p.yaml"), &text).map(|file| file.camera_info).map_err(|error| error.to_string())
    }

    #[test]
    fn matrices_are_read_row_by_row_however_they_are_nested() {
        let k = [60.0, 0.0, 32.0, 0.0, 61.0, 24.0, 0.0, 0.0, 1.0];
        let p = [70.0, 0.0, 33.0, 5.0, 0.0, 71.0, 25.0, 6.0, 0.0, 0.0, 1.0, 0.0];
        for text in [
            "K: [[60, 0, 32], [0, 61, 24], [0, 0, 1]]\nP: [[70, 0, 33, 5], [0, 71, 25, 6], [0, 0, 1, 0]]\n\
             D: [[0.1, 0.2, 0, 0, 0]]\n",
            "K:\n- [60, 0, 32]\n- [0, 61, 24]\n- - 0.0\n  - 0\n  - 1\nP: [70, 0, 33, 5, 0, 71, 25, 6, 0, 0, 1, 0]\n\
             D: [[0.1], [0.2], [0], [0], [0]]\n",
            "camera_matrix: {rows: 3, cols: 3, data: [[60, 0, 32], [0, 61, 24], [0, 0, 1]]}\n\
             projection_matrix: {data: [[70, 0, 33, 5, 0, 71, 25, 6, 0, 0, 1, 0]]}\n\
             distortion_coefficients: {rows: 1, cols: 5, data: [[0.1, 0.2, 0, 0, 0]]}\n",
            "camera_matrix: [[60, 0, 32], [0, 61, 24], [0, 0, 1]]\ndistortion_coefficients: [0.1, 0.2, 0, 0, 0]\n\
             projection_matrix: [[70, 0, 33, 5], [0, 71, 25, 6], [0, 0, 1, 0]]\n",
        ] {
            let info = parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
            assert_eq!((info.K, info.P, info.D.as_slice()), (k, p, &[0.1, 0.2, 0.0, 0.0, 0.0][..]), "{text}");
        }
    }

    #[test]
    fn rows_of_another_shape_are_refused_with_key_and_line() {
        for (text, expected) in [
            ("K: [[60, 0, 32], [0, 61, 24], [0, 1]]\n", "K: "),
            ("K: [[60, 0, 32], [0, 61, 24], 0, 0, 1]\n", "K: "),
            ("K: [[60, 0, 32], [0, 61, 24]]\n", "K: "),
            ("P: [[70, 0, 33, 5, 0, 71], [25, 6, 0, 0, 1, 0]]\n", "P: "),
            ("P: [[70, 0, 0], [0, 71, 0], [33, 25, 1], [5, 6, 0]]\n", "P: "),
            ("K: [[[60, 0, 32]], [[0, 61, 24]], [[0, 0, 1]]]\n", "K"),
            ("K: [[60, 0, .nan], [0, 61, 24], [0, 0, 1]]\n", "not a finite number"),
            ("K: [[60, 0, x], [0, 61, 24], [0, 0, 1]]\n", "K[0][2]"),
            ("camera_matrix: {rows: 2, data: [[60, 0, 32], [0, 61, 24], [0, 0, 1]]}\n", "camera_matrix.rows"),
            ("camera_matrix: {fx: 60}\n", "data"),
            ("camera_matrix: 60\n", "{rows, cols, data} or a list of numbers"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(expected) && error.contains("line 3 "), "{text}{error}");
        }
    }
}
