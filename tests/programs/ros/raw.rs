//! Plain sockets in place of a ROS library: peers that behave as no library does.

use rcs_tests::ros::{wait_until, RosMaster, PATIENCE};
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};

/// Calls a method of the master or of a node with strings as parameters; the answer's XML.
pub(crate) fn call(uri: &str, method: &str, params: &[&str]) -> io::Result<String> {
    let protocols = "<array><data><value><array><data><value>TCPROS</value></data></array></value></data></array>";
    let param = |text: &&str| match *text {
        "TCPROS" => format!("<param><value>{protocols}</value></param>"),
        text => format!("<param><value><string>{text}</string></value></param>"),
    };
    call_xml(uri, method, &params.iter().map(param).collect::<String>())
}

/// Calls a method with parameters in XML.
pub(crate) fn call_xml(uri: &str, method: &str, params: &str) -> io::Result<String> {
    let body = format!("<methodCall><methodName>{method}</methodName><params>{params}</params></methodCall>");
    let host = uri.trim_start_matches("http://").trim_end_matches('/');
    let mut stream = TcpStream::connect(host)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    write!(stream, "POST / HTTP/1.0\r\nContent-Length: {}\r\nContent-Type: text/xml\r\n\r\n{body}", body.len())?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer)?;
    Ok(answer)
}

/// The text in the last element of a name.
fn last_element<'a>(xml: &'a str, name: &str) -> &'a str {
    let inside = xml.rsplit(&format!("<{name}>")).next().unwrap_or_default();
    inside.split('<').next().unwrap_or_default()
}

/// The address of a node's API, as soon as it is registered.
pub(crate) fn node_uri(master: &RosMaster, node: &str) -> String {
    let mut uri = String::new();
    wait_until(PATIENCE, || {
        let answer = call(&master.uri(), "lookupNode", &["/raw", node]).unwrap();
        last_element(&answer, "string").clone_into(&mut uri);
        uri.starts_with("http://")
    });
    uri
}

/// The port on which a node sends a topic.
pub(crate) fn topic_port(master: &RosMaster, node: &str, topic: &str) -> u16 {
    let answer = call(&node_uri(master, node), "requestTopic", &["/raw", topic, "TCPROS"]).unwrap();
    let number = ["i4", "int"].map(|name| last_element(&answer, name).parse().ok());
    number.into_iter().flatten().last().unwrap_or_else(|| panic!("{answer}"))
}

/// Fields as TCPROS sends them.
pub(crate) fn header(fields: &[(&str, &str)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, value) in fields {
        let field = format!("{name}={value}");
        bytes.extend_from_slice(&(field.len() as u32).to_le_bytes());
        bytes.extend_from_slice(field.as_bytes());
    }
    [&(bytes.len() as u32).to_le_bytes(), bytes.as_slice()].concat()
}

/// What comes behind its own length.
pub(crate) fn read_framed(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let mut len = [0; 4];
    stream.read_exact(&mut len)?;
    let mut bytes = vec![0; u32::from_le_bytes(len) as usize];
    stream.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// A connection to a topic, from which nothing but the publisher's header was read.
pub(crate) fn subscribe(master: &RosMaster, node: &str, topic: &str, name: &str) -> TcpStream {
    let mut stream = TcpStream::connect(("127.0.0.1", topic_port(master, node, topic))).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let fields = [("callerid", name), ("topic", topic), ("type", "sensor_msgs/Image"), ("md5sum", "*")];
    stream.write_all(&header(&fields)).unwrap();
    read_framed(&mut stream).unwrap();
    stream
}

/// A node whose API accepts connections and never answers, registered as publisher of a topic.
pub(crate) fn hanging_publisher(master: &RosMaster, node: &str, topic: &str, ros_type: &str) -> TcpListener {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let uri = format!("http://{}/", listener.local_addr().unwrap());
    call(&master.uri(), "registerPublisher", &[node, topic, ros_type, &uri]).unwrap();
    listener
}
