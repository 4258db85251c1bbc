//! What rosrust 0.9 names of xml-rpc 0.1, without a network.
//!
//! Of rosrust this project takes the traits and types of messages, and ROS's names and arguments. Its node, which is
//! what speaks XML-RPC, is never started: `rcs_ros` has one with time limits. The real xml-rpc would bring an HTTP
//! client of 2017 and an HTTP server, 80 crates; here every call fails and no server starts.
#![forbid(unsafe_code)]
#![allow(missing_docs, reason = "the names are those of xml-rpc 0.1")]

use std::collections::HashMap;
use std::convert::Infallible;
use std::marker::PhantomData;
use std::net::SocketAddr;
use std::str::FromStr;

use serde::de::Visitor;
use serde::{forward_to_deserialize_any, Deserialize, Deserializer, Serialize};

pub mod error {
    use std::fmt;

    #[derive(Debug)]
    pub struct Error;

    impl fmt::Display for Error {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("rosrust was built without XML-RPC")
        }
    }

    impl std::error::Error for Error {}

    impl serde::de::Error for Error {
        fn custom<T: fmt::Display>(_: T) -> Self {
            Self
        }
    }

    pub type Result<T> = std::result::Result<T, Error>;
}

pub mod rouille {
    pub struct Request;
    pub struct Response;
}

pub mod server {
    pub use crate::BoundServer;
}

use error::{Error, Result};

#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Int(i32),
    Bool(bool),
    String(String),
    Double(f64),
    DateTime(String),
    Base64(Vec<u8>),
    Array(Vec<Value>),
    Struct(HashMap<String, Value>),
}

impl<'de> Deserializer<'de> for Value {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value> {
        Err(Error)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

pub type Params = Vec<Value>;

#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub code: i32,
    pub message: String,
}

pub type Response = std::result::Result<Params, Fault>;

pub struct Url;

impl FromStr for Url {
    type Err = Error;

    fn from_str(_: &str) -> Result<Self> {
        Ok(Self)
    }
}

pub struct Client;

impl Client {
    pub fn new() -> Result<Self> {
        Err(Error)
    }

    pub fn call<'a, Q: Serialize, A: Deserialize<'a>>(
        &mut self,
        _: &Url,
        _: impl Into<String>,
        _: Q,
    ) -> Result<std::result::Result<A, Fault>> {
        Err(Error)
    }
}

pub fn call_value(_: &Url, _: impl Into<String>, _: Params) -> Result<Response> {
    Err(Error)
}

pub fn into_params(_: &impl Serialize) -> Result<Params> {
    Err(Error)
}

#[derive(Default)]
pub struct Server;

impl Server {
    pub fn register_value(&mut self, _: impl Into<String>, _: impl Fn(Params) -> Response + Send + Sync + 'static) {}

    pub fn set_on_missing(&mut self, _: impl Fn(Params) -> Response + Send + Sync + 'static) {}

    pub fn bind(self, _: &SocketAddr) -> Result<BoundServer<fn(&rouille::Request) -> rouille::Response>> {
        Err(Error)
    }
}

/// A server that cannot be made.
pub struct BoundServer<F>(Infallible, PhantomData<F>);

impl<F> BoundServer<F> {
    pub fn local_addr(&self) -> SocketAddr {
        match self.0 {}
    }

    pub fn poll(&self) {
        match self.0 {}
    }
}
