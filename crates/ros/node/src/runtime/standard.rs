//! Standard functions of every node: lifecycle, parameters, diagnostics, check of the middleware.

use std::rc::Rc;
use std::time::{Duration, Instant};

use futures::future::{Either, select};
use planesman_msgs::{
    diagnostic_msgs::msg::DiagnosticArray,
    lifecycle_msgs::{
        msg::TransitionEvent,
        srv::{
            ChangeState, ChangeStateResponse, GetAvailableStates, GetAvailableStatesResponse,
            GetAvailableTransitions, GetAvailableTransitionsResponse, GetState, GetStateResponse,
        },
    },
    rcl_interfaces::{
        msg::{Parameter, ParameterEvent},
        srv::{
            DescribeParameters, DescribeParametersResponse, GetLoggerLevels, GetParameterTypes,
            GetParameterTypesResponse, GetParameters, GetParametersResponse, ListParameters,
            ListParametersResponse, SetLoggerLevels, SetParameters, SetParametersAtomically,
            SetParametersAtomicallyResponse, SetParametersResponse,
        },
    },
    type_description_interfaces::srv::GetTypeDescription,
};
use planesman_parameters::Parameters;
use rustdds::{ThreadWatch, refusals};
use smol::{
    Timer as SmolTimer,
    channel::{Receiver, Sender},
};

use super::Runtime;
use crate::{
    clock_source, diagnostics,
    error::Result,
    lifecycle::{Change, Lifecycle},
    logger_levels,
    qos::Qos,
    qos_overrides, type_description,
    watchdog::Watchdog,
};

/// Interval of the diagnostics.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_secs(1);

/// Minimum time between two log lines about refused messages.
const REFUSALS_PERIOD: Duration = Duration::from_secs(5);

/// Time without further changes or messages after which a change is published in the diagnostics. While changes continue, for example when many
/// nodes start at once, diagnostics are published every [`DIAGNOSTICS_PERIOD`].
const DIAGNOSTICS_SETTLING: Duration = Duration::from_millis(100);

impl<E: 'static> Runtime<E> {
    /// The node's lifecycle. A managed node is initially unconfigured; it serves the services of `lifecycle_msgs`, publishes `~/transition_event`,
    /// and turns each completed transition into an event. Other nodes are always active.
    ///
    /// # Errors
    /// An error of the middleware.
    pub fn lifecycle(
        &self,
        managed: bool,
        event: impl Fn(Change) -> E + 'static,
    ) -> Result<Lifecycle> {
        if !managed {
            return Ok(Lifecycle::unmanaged());
        }
        let lifecycle = Lifecycle::managed();
        let events =
            self.unlisted_publisher::<TransitionEvent>("~/transition_event", Qos::reliable(10))?;
        let (shared, sender) = (Rc::clone(&self.shared), self.sender.clone());
        let of = || lifecycle.clone();
        let changed = of();
        self.serve_with::<ChangeState, _>("~/change_state", async move |request, r, _turn| {
            let made = changed.change(&request.transition, &shared.clock.now());
            let success = made.is_some();
            if let Some((change, steps)) = made {
                log::info!("{change:?}: {}", changed.label());
                for step in &steps {
                    events.publish(step);
                }
                let _ = sender.send(event(change).into()).await; // Fails only at shutdown.
            }
            r.answer(ChangeStateResponse { success });
        })?;
        let told = of();
        self.answer_with::<GetState>("~/get_state", move |_| GetStateResponse {
            current_state: told.current(),
        })?;
        self.answer_with::<GetAvailableStates>("~/get_available_states", |_| {
            GetAvailableStatesResponse {
                available_states: Lifecycle::states(),
            }
        })?;
        let transitions = |available_transitions| GetAvailableTransitionsResponse {
            available_transitions,
        };
        let told = of();
        let available = move |_| transitions(told.available());
        self.answer_with::<GetAvailableTransitions>("~/get_available_transitions", available)?;
        let graph = move |_| transitions(Lifecycle::graph());
        self.answer_with::<GetAvailableTransitions>("~/get_transition_graph", graph)?;
        Ok(lifecycle)
    }

    /// Serves the six parameter services and publishes `/parameter_events`.
    pub(super) fn serve_parameters<P: Parameters + 'static>(
        &self,
        on_parameters: fn(P) -> E,
    ) -> Result<()> {
        let events =
            self.unlisted_publisher::<ParameterEvent>("/parameter_events", Qos::reliable(1000))?;
        let (shared, parameters, sender) = (
            Rc::clone(&self.shared),
            Rc::clone(&self.parameters),
            self.sender.clone(),
        );
        let announce = Rc::new(async move |changed: Vec<Parameter>| {
            if changed.is_empty() {
                return;
            }
            for parameter in &changed {
                log::info!("parameter {} changed", parameter.name);
            }
            let (uses_sim_time, new) = {
                let parameters = parameters.borrow();
                (
                    parameters.uses_sim_time(),
                    P::from_values(&parameters.values),
                )
            };
            if let Err(error) = clock_source::set_source(&shared, uses_sim_time) {
                log::error!("no /clock: {error}");
            }
            events.publish(&ParameterEvent {
                stamp: shared.clock.now(),
                node: shared.names.full(),
                changed_parameters: changed,
                ..ParameterEvent::default()
            });
            match new {
                Ok(new) => drop(sender.send(on_parameters(new).into()).await),
                Err(refusal) => log::error!("{refusal}"),
            }
        });

        let of = || Rc::clone(&self.parameters);
        let parameters = of();
        self.answer_with::<GetParameters>("~/get_parameters", move |request| {
            let values = parameters.borrow().get(&request.names);
            GetParametersResponse { values }
        })?;
        let parameters = of();
        self.answer_with::<GetParameterTypes>("~/get_parameter_types", move |request| {
            let types = parameters.borrow().types(&request.names);
            GetParameterTypesResponse { types }
        })?;
        let parameters = of();
        self.answer_with::<DescribeParameters>("~/describe_parameters", move |request| {
            let descriptors = parameters.borrow().describe(&request.names);
            DescribeParametersResponse { descriptors }
        })?;
        let parameters = of();
        self.answer_with::<ListParameters>("~/list_parameters", move |request| {
            let result = parameters.borrow().list(&request);
            ListParametersResponse { result }
        })?;
        let (parameters, notify) = (of(), Rc::clone(&announce));
        self.serve_with::<SetParameters, _>("~/set_parameters", async move |request, r, _turn| {
            let (results, changed) = parameters.borrow_mut().set_each(request);
            r.answer(SetParametersResponse { results });
            notify(changed).await;
        })?;
        let (parameters, notify) = (of(), announce);
        self.serve_with::<SetParametersAtomically, _>(
            "~/set_parameters_atomically",
            async move |request, r, _turn| {
                let (result, changed) = parameters.borrow_mut().set_together(request.parameters);
                r.answer(SetParametersAtomicallyResponse { result });
                notify(changed).await;
            },
        )
    }

    /// Serves type descriptions and log levels, if the parameters request them.
    pub(super) fn serve_types_and_levels(&self) -> Result<()> {
        if self.parameters.borrow().describes_types() {
            self.answer_with::<GetTypeDescription>("~/get_type_description", |request| {
                type_description::answer(&request)
            })?;
        }
        if self.parameters.borrow().serves_logger_levels() {
            self.answer_with::<GetLoggerLevels>("~/get_logger_levels", logger_levels::get)?;
            self.answer_with::<SetLoggerLevels>("~/set_logger_levels", logger_levels::set)?;
        }
        Ok(())
    }

    /// Publishes `/diagnostics` every second, and soon after a change.
    pub(super) fn send_diagnostics(&self, changed: Receiver<()>) -> Result<()> {
        let publisher =
            self.unlisted_publisher::<DiagnosticArray>("/diagnostics", Qos::reliable(10))?;
        let shared = Rc::clone(&self.shared);
        self.shared.spawn(async move {
            let mut due = Instant::now() + DIAGNOSTICS_PERIOD;
            let mut settled = due;
            let mut look = Instant::now() + DIAGNOSTICS_SETTLING;
            // The messages of the connections: at the last look, and as told.
            let (mut seen, mut told) = (0, 0);
            loop {
                let change = changed.recv();
                let time = shared.sleep_until(due.min(settled).min(look));
                futures::pin_mut!(change, time);
                let next = select(change, time).await;
                let now = Instant::now();
                if matches!(next, Either::Left(_)) && now < due {
                    settled = now + DIAGNOSTICS_SETTLING;
                    continue;
                }
                look = now + DIAGNOSTICS_SETTLING;
                let count = diagnostics::messages(&shared);
                let has_stopped = count == seen && count != told;
                seen = count;
                if has_stopped || now >= due.min(settled) {
                    publisher.publish(&diagnostics::array(&shared));
                    due = now + DIAGNOSTICS_PERIOD;
                    settled = due;
                    told = count;
                }
            }
        });
        Ok(())
    }

    /// Once a second: publishes the messages that the middleware has refused, and fails if a thread of the middleware has ended.
    pub(super) fn watch_middleware(&self, threads: ThreadWatch, fail: Sender<String>) {
        let shared = Rc::downgrade(&self.shared);
        let mut overrides = Some(Rc::clone(&self.parameters));
        self.shared.spawn(async move {
            let mut watchdog = Watchdog::default();
            let mut before = refusals();
            let (mut told, mut next_word) = (0, Instant::now());
            loop {
                // A timer of its own: the middleware's may have stopped.
                SmolTimer::after(DIAGNOSTICS_PERIOD).await;
                let Some(shared) = shared.upgrade() else {
                    return;
                };
                // Once: by then a node has opened its topics.
                if let Some(parameters) = overrides.take() {
                    qos_overrides::warn_of_unused(&parameters.borrow().values, &shared.endpoints.borrow());
                }
                if let Some(trouble) = watchdog.look(threads.threads()) {
                    let _ =
                        fail.try_send(format!("{trouble}: the node no longer receives messages"));
                }
                let now = refusals();
                let [.., (_, samples)] = now;
                if samples > told && next_word <= Instant::now() {
                    log::warn!(
                        "{} messages refused: each is larger than this node accepts, or exceeds its memory limit",
                        samples - told
                    );
                    told = samples;
                    next_word = Instant::now() + REFUSALS_PERIOD;
                }
                diagnostics::set_refusals(&shared, before, now);
                before = now;
            }
        });
    }
}
