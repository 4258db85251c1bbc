//! A message of any type that a display draws. The list at the end of the code names the types: one line adds one.

use crate::fields::{self, WireField};
use crate::std_msgs::Header;
use crate::{Image, OccupancyGrid, PointCloud2};
use rosrust::{Message, RosMsg};
use std::io;
use std::sync::Arc;

/// Decodes a small message, which keeps none of the bytes.
#[expect(clippy::needless_pass_by_value, reason = "decoders of large messages keep the bytes")]
fn small<T: RosMsg>(bytes: Vec<u8>) -> io::Result<T> {
    crate::decode(&bytes)
}

/// Decodes a small message with arrays of numbers.
#[expect(clippy::needless_pass_by_value, reason = "decoders of large messages keep the bytes")]
fn with_numbers<T: WireField>(bytes: Vec<u8>) -> io::Result<T> {
    Ok(fields::decode(&bytes)?)
}

fn cloud(bytes: Vec<u8>) -> io::Result<PointCloud2> {
    Ok(PointCloud2::from_bytes(Arc::new(bytes))?)
}

fn image(bytes: Vec<u8>) -> io::Result<Image> {
    Ok(Image::from_bytes(Arc::new(bytes))?)
}

fn occupancy_grid(bytes: Vec<u8>) -> io::Result<OccupancyGrid> {
    Ok(OccupancyGrid::from_bytes(Arc::new(bytes))?)
}

/// A type of message that an [`AnyMessage`] can hold.
pub trait TypedMessage: Send + Sync + 'static {
    /// The type.
    const KIND: MessageKind;

    /// The message, if it is of this type.
    fn from_any(message: &AnyMessage) -> Option<&Arc<Self>>;

    /// Header, or that of an array's first element.
    fn header(&self) -> Option<&Header>;
}

/// Code that is generic over a message type, for a [`MessageKind`] known at run time.
///
/// ```
/// use rcs_messages::{Message, MessageKind, MessageVisitor};
///
/// struct TypeName;
///
/// impl MessageVisitor for TypeName {
///     type Output = String;
///
///     fn visit<T: Message>(self) -> String {
///         T::msg_type()
///     }
/// }
///
/// assert_eq!(MessageKind::Path.visit(TypeName), "nav_msgs/Path");
/// ```
pub trait MessageVisitor {
    /// Return type of [`visit`](Self::visit).
    type Output;

    /// Runs the code for messages of type `T`.
    fn visit<T: Message>(self) -> Self::Output;
}

macro_rules! any_message {
    ($($variant:ident($type:ty) $ros:literal $decode:path, $header:expr;)*) => {
        /// A type of message that displays subscribe to.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum MessageKind {
            $(#[doc = concat!("[`", stringify!($type), "`]")] $variant,)*
        }

        /// A message of one of the types of [`MessageKind`].
        #[derive(Clone, Debug)]
        pub enum AnyMessage {
            $(#[doc = concat!("[`", stringify!($type), "`]")] $variant(Arc<$type>),)*
        }

        impl MessageKind {
            /// All kinds.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Type name, `package/Name`.
            pub fn ros_type(self) -> &'static str {
                match self {
                    $(Self::$variant => $ros,)*
                }
            }

            /// Checksum of the definition.
            pub fn md5sum(self) -> String {
                match self {
                    $(Self::$variant => <$type as Message>::md5sum(),)*
                }
            }

            /// Text of the definition with those of its parts.
            pub fn definition(self) -> String {
                match self {
                    $(Self::$variant => <$type as Message>::msg_definition(),)*
                }
            }

            /// Runs generic code for the Rust type of this kind.
            pub fn visit<V: MessageVisitor>(self, visitor: V) -> V::Output {
                match self {
                    $(Self::$variant => visitor.visit::<$type>(),)*
                }
            }

            /// Decodes a message; big ones are copied once.
            ///
            /// # Errors
            /// The bytes are not a message of this kind.
            pub fn decode(self, bytes: &[u8]) -> io::Result<AnyMessage> {
                self.decode_owned(bytes.to_vec())
            }

            /// Decodes a message; big ones keep the bytes and copy nothing.
            ///
            /// # Errors
            /// The bytes are not a message of this kind.
            pub fn decode_owned(self, bytes: Vec<u8>) -> io::Result<AnyMessage> {
                match self {
                    $(Self::$variant => $decode(bytes).map(|m: $type| AnyMessage::$variant(Arc::new(m))),)*
                }
            }

            /// Name of the function that decodes it.
            #[cfg(test)]
            fn decoder(self) -> &'static str {
                match self {
                    $(Self::$variant => stringify!($decode),)*
                }
            }
        }

        impl AnyMessage {
            /// Kind of the message.
            pub fn kind(&self) -> MessageKind {
                match self {
                    $(Self::$variant(_) => MessageKind::$variant,)*
                }
            }

            /// Encodes the message.
            pub fn encode(&self) -> Vec<u8> {
                match self {
                    $(Self::$variant(message) => crate::encode(&**message),)*
                }
            }
        }

        $(impl TypedMessage for $type {
            const KIND: MessageKind = MessageKind::$variant;

            fn from_any(message: &AnyMessage) -> Option<&Arc<Self>> {
                if let AnyMessage::$variant(message) = message {
                    Some(message)
                } else {
                    None
                }
            }

            fn header(&self) -> Option<&Header> {
                let header: fn(&$type) -> Option<&Header> = $header;
                header(self)
            }
        })*

        /// Header of a message, or that of an array's first element.
        pub fn header(message: &AnyMessage) -> Option<&Header> {
            match message {
                $(AnyMessage::$variant(message) => message.header(),)*
            }
        }
    };
}

impl MessageKind {
    /// Kind of the type `package/Name`.
    pub fn from_ros_type(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.ros_type() == name)
    }
}

any_message! {
    PointCloud2(crate::PointCloud2) "sensor_msgs/PointCloud2" cloud, |m| Some(&m.header);
    Image(crate::Image) "sensor_msgs/Image" image, |m| Some(&m.header);
    CameraInfo(crate::sensor_msgs::CameraInfo) "sensor_msgs/CameraInfo" with_numbers, |m| Some(&m.header);
    Marker(crate::visualization_msgs::Marker) "visualization_msgs/Marker" small, |m| Some(&m.header);
    MarkerArray(crate::visualization_msgs::MarkerArray) "visualization_msgs/MarkerArray" small, |m| m.markers.first().map(|m| &m.header);
    Path(crate::nav_msgs::Path) "nav_msgs/Path" small, |m| Some(&m.header);
    PoseStamped(crate::geometry_msgs::PoseStamped) "geometry_msgs/PoseStamped" small, |m| Some(&m.header);
    PoseArray(crate::geometry_msgs::PoseArray) "geometry_msgs/PoseArray" small, |m| Some(&m.header);
    PointStamped(crate::geometry_msgs::PointStamped) "geometry_msgs/PointStamped" small, |m| Some(&m.header);
    PolygonStamped(crate::geometry_msgs::PolygonStamped) "geometry_msgs/PolygonStamped" small, |m| Some(&m.header);
    PoseWithCovarianceStamped(crate::geometry_msgs::PoseWithCovarianceStamped) "geometry_msgs/PoseWithCovarianceStamped" small, |m| Some(&m.header);
    WrenchStamped(crate::geometry_msgs::WrenchStamped) "geometry_msgs/WrenchStamped" small, |m| Some(&m.header);
    TwistStamped(crate::geometry_msgs::TwistStamped) "geometry_msgs/TwistStamped" small, |m| Some(&m.header);
    AccelStamped(crate::geometry_msgs::AccelStamped) "geometry_msgs/AccelStamped" small, |m| Some(&m.header);
    Odometry(crate::nav_msgs::Odometry) "nav_msgs/Odometry" small, |m| Some(&m.header);
    GridCells(crate::nav_msgs::GridCells) "nav_msgs/GridCells" small, |m| Some(&m.header);
    OccupancyGrid(crate::OccupancyGrid) "nav_msgs/OccupancyGrid" occupancy_grid, |m| Some(&m.header);
    OccupancyGridUpdate(crate::map_msgs::OccupancyGridUpdate) "map_msgs/OccupancyGridUpdate" with_numbers, |m| Some(&m.header);
    PointCloud(crate::sensor_msgs::PointCloud) "sensor_msgs/PointCloud" with_numbers, |m| Some(&m.header);
    LaserScan(crate::sensor_msgs::LaserScan) "sensor_msgs/LaserScan" with_numbers, |m| Some(&m.header);
    Range(crate::sensor_msgs::Range) "sensor_msgs/Range" small, |m| Some(&m.header);
    FluidPressure(crate::sensor_msgs::FluidPressure) "sensor_msgs/FluidPressure" small, |m| Some(&m.header);
    Illuminance(crate::sensor_msgs::Illuminance) "sensor_msgs/Illuminance" small, |m| Some(&m.header);
    RelativeHumidity(crate::sensor_msgs::RelativeHumidity) "sensor_msgs/RelativeHumidity" small, |m| Some(&m.header);
    Temperature(crate::sensor_msgs::Temperature) "sensor_msgs/Temperature" small, |m| Some(&m.header);
    JointState(crate::sensor_msgs::JointState) "sensor_msgs/JointState" with_numbers, |m| Some(&m.header);
    CompressedImage(crate::sensor_msgs::CompressedImage) "sensor_msgs/CompressedImage" with_numbers, |m| Some(&m.header);
    InteractiveMarkerInit(crate::visualization_msgs::InteractiveMarkerInit) "visualization_msgs/InteractiveMarkerInit" small, |m| m.markers.first().map(|m| &m.header);
    InteractiveMarkerUpdate(crate::visualization_msgs::InteractiveMarkerUpdate) "visualization_msgs/InteractiveMarkerUpdate" small, |m| m.markers.first().map(|m| &m.header);
    TFMessage(crate::tf2_msgs::TFMessage) "tf2_msgs/TFMessage" small, |m| m.transforms.first().map(|t| &t.header);
    Clock(crate::rosgraph_msgs::Clock) "rosgraph_msgs/Clock" small, |_| None;
    Text(crate::std_msgs::String) "std_msgs/String" small, |_| None;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visualization_msgs::{Marker, MarkerArray};
    use proptest::prelude::*;

    #[test]
    fn a_type_is_found_by_its_name() {
        assert_eq!(MessageKind::PointCloud2.ros_type(), PointCloud2::msg_type());
        for kind in MessageKind::ALL {
            assert_eq!(MessageKind::from_ros_type(kind.ros_type()), Some(*kind));
        }
        assert_eq!(MessageKind::from_ros_type("sensor_msgs/Joy"), None);
    }

    #[test]
    fn an_array_has_the_header_of_its_first_marker() {
        let marker = Marker { header: Header { frame_id: "map".to_owned(), ..Header::default() }, ..Marker::default() };
        let bytes = crate::encode(&MarkerArray { markers: vec![marker] });
        let message = MessageKind::MarkerArray.decode(&bytes).unwrap();
        assert_eq!(header(&message).map(|h| h.frame_id.as_str()), Some("map"));
        assert_eq!(message.encode(), bytes);
    }

    #[test]
    fn a_giant_distortion_is_an_error_and_not_an_allocation() {
        let mut bytes = crate::encode(&crate::sensor_msgs::CameraInfo::default());
        // After header (16 bytes), size (8) and the empty model's length (4).
        bytes[28..32].copy_from_slice(&u32::MAX.to_le_bytes());
        let error = MessageKind::CameraInfo.decode(&bytes).unwrap_err();
        assert!(error.to_string().contains("bytes of array elements"), "{error}");
    }

    /// The decoding of the generated types allocates whatever length such an array announces.
    #[test]
    fn types_with_arrays_of_numbers_are_decoded_by_their_fields() {
        let is_array_of_numbers = |line: &str| {
            let kind = line.split_whitespace().next().unwrap_or_default();
            let numbers = ["bool", "byte", "char", "int", "uint", "float"];
            kind.strip_suffix("[]").is_some_and(|element| numbers.contains(&element.trim_end_matches(char::is_numeric)))
        };
        for kind in MessageKind::ALL {
            let has_any = kind.definition().lines().any(is_array_of_numbers);
            let is_big = ["cloud", "image", "occupancy_grid"].contains(&kind.decoder());
            assert_eq!(kind.decoder() == "with_numbers", has_any && !is_big, "{kind:?}");
        }
    }

    #[test]
    fn numbers_are_decoded_as_by_the_generated_types() {
        use crate::sensor_msgs::{CameraInfo, ChannelFloat32, JointState, LaserScan, PointCloud};
        fn check<T: WireField + RosMsg + PartialEq + std::fmt::Debug>(message: &T) {
            let bytes = crate::encode(message);
            assert_eq!(with_numbers::<T>(bytes.clone()).unwrap(), *message);
            for len in 0..bytes.len() {
                assert!(with_numbers::<T>(bytes[..len].to_vec()).is_err(), "{len} bytes");
            }
            assert!(with_numbers::<T>([bytes, vec![0]].concat()).is_err());
        }
        let header = Header { seq: 1, stamp: crate::Time { sec: 2, nsec: 3 }, frame_id: "map".to_owned() };
        let (numbers, doubles) = (vec![1.5_f32, -2.0, f32::MAX], vec![1.5_f64, -2.0]);
        let mut info = CameraInfo { header: header.clone(), height: 4, width: 5, ..CameraInfo::default() };
        (info.distortion_model, info.D, info.K[1], info.P[11]) = ("x".to_owned(), doubles.clone(), 6.0, 7.0);
        (info.binning_x, info.binning_y, info.roi.width, info.roi.do_rectify) = (8, 9, 10, true);
        check(&info);
        let scan = LaserScan { header: header.clone(), angle_min: 1.0, angle_max: 2.0, ..LaserScan::default() };
        check(&LaserScan { range_max: 3.0, ranges: numbers.clone(), intensities: numbers.clone(), ..scan });
        let channels = vec![ChannelFloat32 { name: "intensity".to_owned(), values: numbers }; 2];
        check(&PointCloud { header: header.clone(), points: vec![Default::default(); 2], channels });
        let (name, velocity) = (vec!["a".to_owned(), "b".to_owned()], doubles.clone());
        check(&JointState { header: header.clone(), name, position: doubles, velocity, effort: Vec::new() });
        let data = vec![1, 2, 255];
        check(&crate::sensor_msgs::CompressedImage { header: header.clone(), format: "png".to_owned(), data });
        let data = vec![1, -1, 100];
        check(&crate::map_msgs::OccupancyGridUpdate { header, x: -1, y: 2, width: 3, height: 1, data });
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            for kind in MessageKind::ALL {
                let borrowed = kind.decode(&bytes).is_ok();
                prop_assert_eq!(borrowed, kind.decode_owned(bytes.clone()).is_ok());
            }
        }

        // Bytes that are mostly zero get much further into a message than random ones.
        #[test]
        fn sparse_bytes_never_panic(changes in proptest::collection::vec((0..600usize, any::<u8>()), 0..12), len in 0..600usize) {
            let mut bytes = vec![0; len];
            for (at, value) in changes {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = value;
                }
            }
            for kind in MessageKind::ALL {
                if let Ok(message) = kind.decode(&bytes) {
                    let encoded = message.encode();
                    // What is not UTF-8 in a string is replaced by a longer character.
                    prop_assert!(encoded.len() == bytes.len() || !bytes.is_ascii(), "{} bytes", encoded.len());
                    prop_assert_eq!(kind.decode(&encoded).map(|again| again.encode()).ok(), Some(encoded.clone()));
                }
            }
        }
    }
}
