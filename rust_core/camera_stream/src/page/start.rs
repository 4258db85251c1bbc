//! Starts the page's server, and tells the operator its address.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use anyhow::{Context, Result};
use rcs_web::{Access, Limits, Server, Token};

use super::operator::PageOperator;
use crate::options::WebOptions;
use crate::outputs::page::encode_all;
use crate::runtime::shared::NodeState;

/// The token's file below the folder of ROS.
const TOKEN_FILE: &str = "rviz_camera_stream/web_token";

/// Serves the page until the result is dropped. Its address with the token is printed on standard error alone.
///
/// # Errors
/// One line: no token, or an address that cannot be listened at.
pub(crate) fn start(options: &WebOptions, shared: &Arc<NodeState>) -> Result<Server> {
    let option = &options.option;
    let file = rcs_ros::ros_folder()
        .with_context(|| format!("{option}: no folder for the token; set ROS_HOME"))?
        .join(TOKEN_FILE);
    let token = Token::load_or_create(&file).with_context(|| format!("{option}: no token"))?;
    let names = rcs_ros::host_names();
    let access = Access::new(token, names.iter().chain(&options.hosts).cloned());
    let operator = Arc::new(PageOperator::new(shared));
    let pages = shared.page.pages();
    let server = Server::start(options.address, access.clone(), operator, pages.clone(), Limits::default());
    let server = server.with_context(|| {
        format!("{option}: cannot listen at {}; choose another port, or end the program that has it", options.address)
    })?;
    let images = pages.images().clone();
    let encoding = std::thread::Builder::new().name("web-images".to_owned()).spawn(move || encode_all(&images));
    encoding.context("cannot start the thread that encodes images for the page")?;
    let pages = pages.clone();
    rcs_logging::watch_recent_lines(move || pages.log_changed());
    let url = url(server.address(), &names[0]);
    rcs_logging::print_privately(&format!("the operator's page: {url}#token={}", access.token().text()));
    log::info!("the operator's page is at {url}; standard error has its address with the token");
    Ok(server)
}

/// The address for a browser: of a server at all addresses, the name under which others reach this machine.
fn url(address: SocketAddr, name: &str) -> String {
    let port = address.port();
    match address.ip() {
        ip if ip.is_unspecified() => format!("http://{name}:{port}/"),
        IpAddr::V4(ip) => format!("http://{ip}:{port}/"),
        IpAddr::V6(ip) => format!("http://[{ip}]:{port}/"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_address_leads_to_this_machine() {
        let url = |address: &str| url(address.parse().unwrap(), "robot.local");
        assert_eq!(url("127.0.0.1:80"), "http://127.0.0.1:80/");
        assert_eq!([url("0.0.0.0:80"), url("[::]:80")], ["http://robot.local:80/"; 2]);
        assert_eq!(url("[::1]:8080"), "http://[::1]:8080/");
    }
}
