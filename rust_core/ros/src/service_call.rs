//! Calling other nodes' services.

use std::time::{Duration, Instant};

use rcs_messages::ServicePair;

use crate::error::NodeError;
use crate::node::RosNode;
use crate::tcpros::{call_service, Header};
use crate::xmlrpc::{call, client};

impl RosNode {
    /// Calls another node's service and waits for the answer, `timeout` at most, or longer if the system takes longer
    /// to resolve the host's name. Not for the threads that draw or answer calls.
    ///
    /// ```no_run
    /// use rcs_messages::std_srvs::{Trigger, TriggerReq};
    /// use std::time::Duration;
    ///
    /// let node = rcs_ros::RosNode::connect("caller", &|| false)?;
    /// let answer = node.call::<Trigger>("/projector/save", &TriggerReq {}, Duration::from_secs(2))?;
    /// println!("{}", answer.message);
    /// # Ok::<(), rcs_ros::NodeError>(())
    /// ```
    ///
    /// # Errors
    /// [`NodeError::Name`], or [`NodeError::Call`] with the reason.
    pub fn call<T: ServicePair>(
        &self,
        service: &str,
        request: &T::Request,
        timeout: Duration,
    ) -> Result<T::Response, NodeError> {
        let service = self.resolve(service)?;
        let failed = |reason: String| NodeError::Call { service: service.clone(), reason };
        let deadline = Instant::now() + timeout;
        let master = self.network().registrar().master();
        let names = [master.node_name.as_str().into(), service.as_str().into()];
        let api = call(&master.uri, "lookupService", &names, timeout).map_err(|error| {
            failed(match error.is_answer() {
                true => "no node offers it".to_owned(),
                false => format!("the ROS master at {} does not answer: {error}", master.uri),
            })
        })?;
        let api = api.as_str().unwrap_or_default().replacen("rosrpc://", "http://", 1);
        let addresses = client::addresses(&api).map_err(|error| failed(error.to_string()))?;
        let unreachable = |error| failed(format!("its node at {api} cannot be reached: {error}"));
        let mut stream = client::connect(&addresses, deadline).map_err(unreachable)?;
        let (md5sum, ros_type) = (T::md5sum(), T::msg_type());
        let header = Header::new([
            ("callerid", master.node_name.as_str()),
            ("service", &service),
            ("md5sum", &md5sum),
            ("type", &ros_type),
        ]);
        let request = rcs_messages::encode(request);
        let response = call_service(&mut stream, &header, &request, deadline).map_err(failed)?;
        rcs_messages::decode(&response).map_err(|error| failed(format!("its answer is invalid: {error}")))
    }
}
