//! Address of the operator's page.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use rcs_node_support::node_options::InvalidOption;

use super::arguments::WebArgs;
use crate::safety::names::NONE;

/// The operator's page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct WebOptions {
    /// Where it is served.
    pub(crate) address: SocketAddr,
    /// Name of the option that says so.
    pub(crate) option: String,
    /// Further names by which browsers reach it.
    pub(crate) hosts: Vec<String>,
}

impl WebOptions {
    /// The page's options; `None` without a page.
    ///
    /// # Errors
    /// [`InvalidOption`].
    pub(super) fn new(args: &WebArgs, name_of: &dyn Fn(&str) -> String) -> Result<Option<Self>, InvalidOption> {
        let hosts = args.web_hosts.iter().filter(|name| *name != NONE);
        let check = |name: &String| match is_name(name) {
            true => Ok(name.clone()),
            false => Err(InvalidOption::new(&name_of("web-hosts"), name, "not the name of a machine, without a port")),
        };
        let hosts = hosts.map(check).collect::<Result<_, _>>()?;
        let Some(text) = args.web.as_ref().filter(|text| *text != NONE) else { return Ok(None) };
        let option = name_of("web");
        match address(text) {
            Some(address) => Ok(Some(Self { address, option, hosts })),
            None => {
                let reason = "no port, as 8080, nor an IP address with a port, as 0.0.0.0:8080";
                Err(InvalidOption::new(&option, text, reason))
            }
        }
    }
}

fn address(text: &str) -> Option<SocketAddr> {
    let port = text.parse::<u16>().map(|port| SocketAddr::from((IpAddr::from(Ipv4Addr::LOCALHOST), port)));
    port.ok().or_else(|| text.parse().ok())
}

fn is_name(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(web: &str, hosts: &[&str]) -> Result<Option<WebOptions>, String> {
        let args =
            WebArgs { web: Some(web.to_owned()), web_hosts: hosts.iter().map(|&name| name.to_owned()).collect() };
        WebOptions::new(&args, &|option| format!("--{option}")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_port_is_of_this_machine_unless_an_address_is_given() {
        let address = |text| options(text, &[]).unwrap().unwrap().address.to_string();
        assert_eq!(address("8080"), "127.0.0.1:8080");
        assert_eq!([address("0.0.0.0:80"), address("[::1]:0")], ["0.0.0.0:80", "[::1]:0"]);
        for wrong in ["", "x", "70000", "robot:8080", "0.0.0.0", ":8080"] {
            let error = options(wrong, &[]).unwrap_err();
            assert!(error.starts_with(&format!("invalid value '{wrong}' for --web: no port, as 8080, nor")), "{error}");
        }
    }

    #[test]
    fn hosts_are_names_without_ports() {
        assert_eq!(options("1", &["robot.local", "none"]).unwrap().unwrap().hosts, ["robot.local"]);
        assert!(options("none", &["robot.local:8080"]).unwrap_err().contains("for --web-hosts: not the name"));
    }
}
