//! Start of a node.

use std::cell::RefCell;
use std::net::Ipv4Addr;
use std::rc::Rc;

use futures::StreamExt as _;
use planesman_msgs::{
    Message as _,
    rcl_interfaces::msg::{Log, ParameterEvent},
    rmw_dds_common::msg::ParticipantEntitiesInfo,
    rosgraph_msgs::msg::Clock as ClockMessage,
};
use planesman_parameters::Parameters;
use ros2_client::{Context, NodeName, NodeOptions};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, StatusEvented as _, discovery::announce_type_hash,
};
use smol::{LocalExecutor, channel::bounded};

use super::{EventGuard, Runtime};
use crate::{
    args::RosArguments,
    clock, clock_source,
    discovery_events::DiscoveryEvents,
    domain::{Domain, static_peers},
    error::{BoxedError, Error, Result},
    file_size,
    graph::Graph,
    logging, memory,
    names::NodeNames,
    parameters::{ParameterServer, STRICT_PARAMETERS},
    receive_limits::ReceiveLimits,
    security::Security,
    service,
    shared::Shared,
    shutdown, timers,
};

/// Number of events queued for the handler; more wait in the middleware.
const QUEUE: usize = 64;

/// Description of a node to start.
pub struct NodeSpec<E, P> {
    /// Default name; `__node` remaps it.
    pub name: &'static str,
    /// Default namespace, such as `/auv`; `__ns` remaps it.
    pub namespace: &'static str,
    /// Rule for the complete set of parameters, beyond the range of each. `use_sim_time` is added to the parameters.
    pub validate: fn(&P) -> Result<(), BoxedError>,
    /// Makes the event for changed parameters.
    pub on_parameters: fn(P) -> E,
}

impl<E: 'static> Runtime<E> {
    /// Starts the node in the domain given by the environment: log, memory limit, parameters, participant, parameter services, diagnostics. Returns
    /// the node and its parameters.
    ///
    /// # Errors
    /// A refused argument, parameter or environment variable, or an error of the middleware.
    pub fn start<P: Parameters + 'static>(
        spec: NodeSpec<E, P>,
        arguments: RosArguments,
    ) -> Result<(Self, P)> {
        Self::start_in(Domain::from_environment()?, spec, arguments)
    }

    /// Starts the node in `domain`.
    ///
    /// # Errors
    /// Same as [`Runtime::start`].
    pub fn start_in<P: Parameters + 'static>(
        domain: Domain,
        spec: NodeSpec<E, P>,
        arguments: RosArguments,
    ) -> Result<(Self, P)> {
        Self::with_receive_limits(domain, spec, arguments, |_| ReceiveLimits::small())
    }

    /// Starts the node in `domain`, with other limits of received messages.
    ///
    /// # Errors
    /// Same as [`Runtime::start`].
    pub fn with_receive_limits<P: Parameters + 'static>(
        domain: Domain,
        spec: NodeSpec<E, P>,
        arguments: RosArguments,
        receive_limits: impl FnOnce(&P) -> ReceiveLimits,
    ) -> Result<(Self, P)> {
        let names = NodeNames::remapped(spec.name, spec.namespace, &arguments.remaps)?;
        logging::install(&names.logger(), &arguments)?;
        for ignored in &arguments.ignored {
            log::warn!("ignored: {ignored}");
        }
        clock::check_machine()?;
        let variable = |name: &str| std::env::var(name).ok();
        let security = Security::asked_for(&arguments.enclave, variable)?;
        if let Some(lack) = security.lack() {
            log::warn!("{lack}");
        }
        let peers = static_peers(variable)?;
        timers::start()?;
        file_size::limit_is_an_error();
        let stop = shutdown::requested()?;
        let strict = variable(STRICT_PARAMETERS).is_some_and(|value| !value.is_empty());
        let parameters = ParameterServer::at_start(spec.validate, &names, &arguments, strict)?;
        let at_start = P::from_values(&parameters.values)?;
        let receive_limits = receive_limits(&at_start);
        memory::limit(&receive_limits)?;
        let mapping = service::mapping()?;
        // The runtime's own types must be known before their endpoints exist.
        announce_type_hash(Log::DDS_TYPE_NAME, Log::TYPE_HASH);
        announce_type_hash(ParameterEvent::DDS_TYPE_NAME, ParameterEvent::TYPE_HASH);
        announce_type_hash(ClockMessage::DDS_TYPE_NAME, ClockMessage::TYPE_HASH);
        announce_type_hash(
            ParticipantEntitiesInfo::DDS_TYPE_NAME,
            ParticipantEntitiesInfo::TYPE_HASH,
        );
        let participant = participant(domain, &peers, &security, &receive_limits)?;
        Graph::replace_writer_of_context(&participant);
        let context = Context::from_domain_participant(participant.clone()).map_err(|reason| {
            Error::Middleware {
                what: "cannot create a ROS context".to_owned(),
                reason: reason.to_string(),
            }
        })?;
        let node_name =
            NodeName::new(&names.namespace, &names.name).map_err(Error::name(&names.full()))?;
        let options = NodeOptions::new()
            .enable_rosout(arguments.rosout)
            .start_parameter_services(false);
        // The node's own, which it never writes to and whose QoS is none of rclcpp's; ours is in `serve_parameters`.
        participant.withhold_next_writer("rt/parameter_events");
        // Its spinner stays unused: it would announce a `/clock` reader of a wrong type, and
        // what it finds out the participant tells as well.
        let mut node = context
            .new_node(node_name, options)
            .map_err(Error::name(&names.full()))?;
        let rosout = arguments.rosout.then(|| node.logging_handle());
        let graph = Graph::new(&participant, context.clone(), &mut node)?;
        let executor = Rc::new(LocalExecutor::new());
        let (diagnostics_due, changed) = bounded(1);
        let shared = Rc::new(Shared::new(
            names,
            arguments.remaps,
            participant.clone(),
            node,
            graph,
            Rc::downgrade(&executor),
            diagnostics_due,
        ));
        logging::begin(rosout, &shared.clock);
        watch_discovery(&shared, &participant);
        let (sender, receiver) = bounded(QUEUE);
        let (fail, failed) = bounded(1);
        let runtime = Self {
            shared,
            executor,
            parameters: Rc::new(RefCell::new(parameters)),
            mapping,
            context,
            sender,
            receiver,
            gate: Rc::default(),
            hold: RefCell::new(EventGuard::Nothing),
            stop,
            failed,
            failure: RefCell::default(),
        };
        clock_source::set_source(&runtime.shared, runtime.parameters.borrow().uses_sim_time())?;
        runtime.serve_parameters(spec.on_parameters)?;
        runtime.serve_types_and_levels()?;
        runtime.send_diagnostics(changed)?;
        runtime.watch_middleware(participant.thread_watch(), fail);
        let range = match (domain.local, peers.as_slice()) {
            (true, []) => ", this machine only".to_owned(),
            (true, peers) => format!(", only this machine and the static peers {peers:?}"),
            (false, []) => String::new(),
            (false, peers) => format!(", static peers {peers:?}"),
        };
        log::info!("up in domain {}{range}", runtime.context.domain_id());
        Ok((runtime, at_start))
    }
}

/// The participant of a domain, with the selected networks and peers.
fn participant(
    domain: Domain,
    peers: &[Ipv4Addr],
    security: &Security,
    receive_limits: &ReceiveLimits,
) -> Result<DomainParticipant> {
    let builder = DomainParticipantBuilder::new(domain.id);
    let builder = match (domain.local, peers.is_empty()) {
        (true, true) => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
        (local, _) => builder.multicast(!local).static_peers(peers.to_vec()),
    };
    let builder = builder.received_bytes(receive_limits.budget, receive_limits.largest);
    security
        .applied(builder)
        .build()
        .map_err(|reason| Error::Middleware {
            what: format!("cannot create a participant in domain {}", domain.id),
            reason: reason.to_string(),
        })
}

/// Handles discovery events of the participant.
fn watch_discovery(shared: &Rc<Shared>, participant: &DomainParticipant) {
    let (ours, listener) = (Rc::clone(shared), participant.status_listener());
    shared.spawn(async move {
        let warnings = DiscoveryEvents::default();
        let mut events = listener.as_async_status_stream();
        while let Some(event) = events.next().await {
            warnings.log(&ours, &event);
            ours.on_discovery(&event);
            ours.request_diagnostics();
        }
    });
}
