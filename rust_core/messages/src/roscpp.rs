//! Services of the package `roscpp` by which rqt_logger_level changes what a node logs.

use crate::fields::{fields_in_order, service_types};
use rosrust_msg::std_srvs::{EmptyReq, EmptyRes};

fields_in_order! {
    /// `roscpp/Logger`: a logger and its level.
    Logger {
        /// Name, such as `ros.rviz_camera_stream`.
        name: String,
        /// Least level that it logs, such as `info`.
        level: String,
    }
    /// Response of [`GetLoggers`].
    GetLoggersRes {
        /// The node's loggers.
        loggers: Vec<Logger>,
    }
    /// Request of [`SetLoggerLevel`].
    SetLoggerLevelReq {
        /// Name of the logger.
        logger: String,
        /// `debug`, `info`, `warn`, `error` or `fatal`.
        level: String,
    }
}

service_types! {
    /// `roscpp/GetLoggers`: lists a node's loggers.
    GetLoggers(EmptyReq) -> GetLoggersRes:
        "roscpp/GetLoggers", "32e97e85527d4678a8f9279894bb64b0", "---\nLogger[] loggers\n";
    /// `roscpp/SetLoggerLevel`: changes a logger's level.
    SetLoggerLevel(SetLoggerLevelReq) -> EmptyRes:
        "roscpp/SetLoggerLevel", "51da076440d78ca1684d36c868df61ea", "string logger\nstring level\n---\n";
}

#[cfg(test)]
mod tests {
    use super::*;
    use rosrust::RosMsg;

    #[test]
    fn requests_and_responses_come_back_as_they_were() {
        let loggers = vec![Logger { name: "ros".to_owned(), level: "info".to_owned() }; 2];
        let response = GetLoggersRes { loggers };
        assert_eq!(GetLoggersRes::decode(&*crate::encode(&response)).unwrap(), response);
        let request = SetLoggerLevelReq { logger: "ros".to_owned(), level: "debug".to_owned() };
        assert_eq!(SetLoggerLevelReq::decode(&*crate::encode(&request)).unwrap(), request);
    }
}
