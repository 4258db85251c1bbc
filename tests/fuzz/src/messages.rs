//! Messages of every type, and the requests of services; images also as the projector's window shows them and as masks
//! of its light, clouds also as surfaces that projectors light.

use rcs_camera_stream::light_mask;
use rcs_messages::{dynamic_reconfigure, roscpp, std_srvs, AnyMessage, Image, MessageKind, RosMsg, ServicePair};
use rcs_window::{ReceivedImage, ScreenImage};

use crate::first_byte;

type Read = fn(&[u8]);

/// What a node's services are asked.
const REQUESTS: [Read; 4] = [
    request::<roscpp::GetLoggers>,
    request::<roscpp::SetLoggerLevel>,
    request::<dynamic_reconfigure::Reconfigure>,
    request::<std_srvs::Trigger>,
];

/// The first byte chooses the type.
pub(crate) fn read(data: &[u8]) {
    let (choice, bytes) = first_byte(data);
    let choice = usize::from(choice) % (MessageKind::ALL.len() + REQUESTS.len());
    match MessageKind::ALL.get(choice) {
        Some(kind) => message(*kind, bytes),
        None => {
            if let Some(read) = REQUESTS.get(choice - MessageKind::ALL.len()) {
                read(bytes);
            }
        }
    }
}

fn message(kind: MessageKind, bytes: &[u8]) {
    let Ok(message) = kind.decode(bytes) else { return };
    assert_eq!(message.kind(), kind);
    let _ = rcs_messages::header(&message);
    match &message {
        AnyMessage::Image(image) => {
            on_screen(image);
            if light_mask(image).is_ok() {
                assert!(image.data().len() >= image.width as usize * image.height as usize);
            }
        }
        AnyMessage::PointCloud2(cloud) => {
            if let Ok(points) = cloud.positions() {
                assert!(4 * points.count() <= cloud.data().len());
            }
        }
        _ => {}
    }
    let encoded = message.encode();
    // What is not UTF-8 in a string is replaced by a longer character, and a bool has one way to be true.
    assert!(encoded.len() >= bytes.len(), "{}: {} bytes became {}", kind.ros_type(), bytes.len(), encoded.len());
    let again = kind.decode(&encoded).map(|message| message.encode()).ok();
    assert_eq!(again.as_ref(), Some(&encoded), "{}", kind.ros_type());
}

fn on_screen(image: &Image) {
    let image = ScreenImage::from_received(&ReceivedImage {
        width_px: image.width,
        height_px: image.height,
        step_bytes: image.step,
        encoding: &image.encoding,
        is_bigendian: image.is_bigendian != 0,
        data: image.data(),
    });
    if let Ok(image) = image {
        // Smaller than some, larger than others.
        let mut screen = vec![u32::MAX; 12];
        image.draw_unscaled(&mut screen, 4);
        assert!(!screen.contains(&u32::MAX));
    }
}

fn request<S: ServicePair>(bytes: &[u8]) {
    if let Ok(request) = rcs_messages::decode::<S::Request>(bytes) {
        same_again(&request);
    }
    if let Ok(response) = rcs_messages::decode::<S::Response>(bytes) {
        same_again(&response);
    }
}

fn same_again<T: RosMsg>(message: &T) {
    let encoded = rcs_messages::encode(message);
    let again = rcs_messages::decode::<T>(&encoded).map(|message| rcs_messages::encode(&message)).ok();
    assert_eq!(again, Some(encoded), "{}", std::any::type_name::<T>());
}
