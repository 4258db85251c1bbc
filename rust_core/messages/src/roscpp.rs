//! The services of the package `roscpp` by which rqt_logger_level and `rosservice` change what a running node logs.
//!
//! They are types of our own, so that the programs can be built where that package is not installed.

use crate::fields::fields_in_order;
use rosrust::{Message, RosMsg, ServicePair};
use rosrust_msg::std_srvs::{EmptyReq, EmptyRes};
use std::io;

fields_in_order! {
    /// `roscpp/Logger`: a logger and what it logs.
    Logger {
        /// Its name, such as `ros.rviz_camera_stream`.
        name: String,
        /// The least level that it logs, such as `info`.
        level: String,
    }
    /// The response of [`GetLoggers`].
    GetLoggersRes {
        /// All of the node's.
        loggers: Vec<Logger>,
    }
    /// The request of [`SetLoggerLevel`].
    SetLoggerLevelReq {
        /// The logger's name.
        logger: String,
        /// `debug`, `info`, `warn`, `error` or `fatal`.
        level: String,
    }
}

/// `roscpp/GetLoggers`: what a node logs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GetLoggers;

/// `roscpp/SetLoggerLevel`: changes what a node logs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetLoggerLevel;

impl ServicePair for GetLoggers {
    type Request = EmptyReq;
    type Response = GetLoggersRes;
}

impl ServicePair for SetLoggerLevel {
    type Request = SetLoggerLevelReq;
    type Response = EmptyRes;
}

/// A service's type is a message in rosrust's eyes; it is never sent.
macro_rules! service_type {
    ($($name:ident: $ros_type:literal, $md5sum:literal, $definition:literal;)*) => {
        $(
            impl RosMsg for $name {
                fn encode<W: io::Write>(&self, _: W) -> io::Result<()> {
                    Ok(())
                }

                fn decode<R: io::Read>(_: R) -> io::Result<Self> {
                    Ok(Self)
                }
            }

            impl Message for $name {
                fn msg_definition() -> String {
                    $definition.to_owned()
                }

                fn md5sum() -> String {
                    $md5sum.to_owned()
                }

                fn msg_type() -> String {
                    $ros_type.to_owned()
                }
            }
        )*
    };
}

service_type! {
    GetLoggers: "roscpp/GetLoggers", "32e97e85527d4678a8f9279894bb64b0", "---\nLogger[] loggers\n";
    SetLoggerLevel: "roscpp/SetLoggerLevel", "51da076440d78ca1684d36c868df61ea", "string logger\nstring level\n---\n";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_responses_come_back_as_they_were() {
        let loggers = vec![Logger { name: "ros".to_owned(), level: "info".to_owned() }; 2];
        let response = GetLoggersRes { loggers };
        assert_eq!(GetLoggersRes::decode(&*crate::encode(&response)).unwrap(), response);
        let request = SetLoggerLevelReq { logger: "ros".to_owned(), level: "debug".to_owned() };
        assert_eq!(SetLoggerLevelReq::decode(&*crate::encode(&request)).unwrap(), request);
    }
}
