//! The service of the package `rviz` by which scripts load and save configs.

use crate::fields::{fields_in_order, service_types};

fields_in_order! {
    /// Request of [`SendFilePath`].
    SendFilePathReq {
        /// Path of a file; in rviz's definition the text of a `std_msgs/String`.
        path: String,
    }
    /// Response of [`SendFilePath`].
    SendFilePathRes {
        /// Whether the file was loaded or saved.
        success: bool,
    }
}

service_types! {
    /// `rviz/SendFilePath`: loads or saves a file.
    SendFilePath(SendFilePathReq) -> SendFilePathRes:
        "rviz/SendFilePath", "92f17244ff295b327b62c307fafe751b", "std_msgs/String path\n---\nbool success\n";
}

#[cfg(test)]
mod tests {
    use super::*;
    use rosrust::RosMsg;

    #[test]
    fn requests_and_responses_come_back_as_they_were() {
        let request = SendFilePathReq { path: "/a.rviz".to_owned() };
        assert_eq!(crate::encode(&request), b"\x07\0\0\0/a.rviz");
        assert_eq!(SendFilePathReq::decode(&*crate::encode(&request)).unwrap(), request);
        let response = SendFilePathRes { success: true };
        assert_eq!(SendFilePathRes::decode(&*crate::encode(&response)).unwrap(), response);
    }
}
