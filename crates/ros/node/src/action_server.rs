//! Action servers: goals with feedback, cancelling and a result.
//!
//! An action `NAME` consists of three services and two topics below `NAME/_action` (design.ros2.org, "Actions"): `send_goal`, `cancel_goal`,
//! `get_result`; `feedback`, `status`. The middleware defines the names and types of these services and topics; this module defines their behaviour:
//!
//! - Every goal is accepted and becomes an event with a [`Goal`], which the node ends with [`Goal::succeed`], [`Goal::abort`] or
//!   [`Goal::cancel`]; immediately if it cannot be done, because a result can give the reason and a rejection cannot. Only a goal with a known
//!   identifier, or with a number that is not finite, is rejected.
//! - A cancel request is accepted for every running goal that it names; each becomes an event.
//! - Results are kept for the last [`REMEMBERED`] goals that have ended; a request for the result of a running goal waits.

use crate::error::{Error, Result};
use std::{
    cell::RefCell,
    future::poll_fn,
    rc::{Rc, Weak},
    task::{Context, Poll},
};

use futures::StreamExt as _;
use planesman_msgs::{
    Action, Message, Service,
    action_msgs::{
        msg::GoalStatusArray,
        srv::{CancelGoal, CancelGoalRequest, CancelGoalResponse},
    },
    builtin_interfaces::msg::Time,
};
pub use ros2_client::action::{GoalId, GoalStatusEnum as GoalStatus};
use ros2_client::{
    ActionTypeName, Name, ReadError, RmwRequestId, Server,
    action::{
        ActionServerQosPolicies, GetResultRequest, GetResultResponse, GoalInfo, SendGoalRequest,
        SendGoalResponse,
    },
    action_msgs, builtin_interfaces,
    error::WriteError,
    service::ServiceMapping,
};
use rustdds::discovery::announce_type_hash;

pub use crate::goals::REMEMBERED;
use crate::{
    answers,
    goals::{Goals, Outcome},
    qos::Qos,
    service::Wire,
    share::RequestSlot,
    shared::Shared,
};

type Middleware<A> = ros2_client::action::ActionServer<
    Wire<<A as Action>::Goal>,
    Wire<<A as Action>::Result>,
    Wire<<A as Action>::Feedback>,
>;

/// An incoming request.
enum Request<A: Action> {
    Goal(RmwRequestId, SendGoalRequest<Wire<A::Goal>>),
    Cancel(RmwRequestId, action_msgs::CancelGoalRequest),
    Result(RmwRequestId, GetResultRequest),
    Refused(ReadError),
}

/// The server of one action.
pub(crate) struct ActionServer<A: Action> {
    shared: Rc<Shared>,
    /// Absolute name, such as `/auv/depth_controller/manoeuvre`.
    name: String,
    middleware: Weak<RefCell<Middleware<A>>>,
    goals: RefCell<Goals<A::Result, RmwRequestId>>,
}

/// A running goal. One of the three methods below ends the goal.
pub struct Goal<A: Action> {
    server: Rc<ActionServer<A>>,
    id: GoalId,
    request: A::Goal,
}

impl<A: Action> Goal<A> {
    /// Identifier given by the client.
    #[must_use]
    pub fn id(&self) -> GoalId {
        self.id
    }

    /// The goal's request.
    #[must_use]
    pub fn request(&self) -> &A::Goal {
        &self.request
    }

    /// Publishes feedback.
    pub fn feedback(&self, feedback: A::Feedback) {
        if self.server.is_finite("feedback", &feedback)
            && let Some(middleware) = self.server.middleware.upgrade()
        {
            let sent = middleware.borrow().send_feedback(self.id, Wire(feedback));
            self.server.warn_of(sent);
        }
    }

    /// Ends the goal as succeeded.
    pub fn succeed(self, result: A::Result) {
        self.end(GoalStatus::Succeeded, result);
    }

    /// Ends the goal as aborted.
    pub fn abort(self, result: A::Result) {
        self.end(GoalStatus::Aborted, result);
    }

    /// Ends the goal as cancelled, as its client requested.
    pub fn cancel(self, result: A::Result) {
        self.end(GoalStatus::Canceled, result);
    }

    fn end(self, status: GoalStatus, result: A::Result) {
        let result = match self.server.is_finite("result", &result) {
            true => result,
            false => A::Result::default(),
        };
        let server = &self.server;
        let waiting = server
            .goals
            .borrow_mut()
            .end(self.id, status, result.clone());
        server.publish_statuses();
        for asker in waiting {
            server.tell_result(asker, status, result.clone());
        }
    }
}

impl<A: Action> ActionServer<A> {
    /// Starts the server, which passes on goals and cancel requests.
    pub(crate) fn serve(
        shared: &Rc<Shared>,
        name: &str,
        mapping: ServiceMapping,
        mut on_goal: impl AsyncFnMut(Goal<A>, RequestSlot) + 'static,
        mut on_cancel: impl AsyncFnMut(GoalId) + 'static,
    ) -> Result<()> {
        let name = shared.service_name(name)?;
        let type_name = announce_action::<A>()?;
        let parsed = Name::parse(&name).map_err(Error::name(&name))?;
        let service = Qos::requests().impatient_profile();
        let [feedback, status] = [Qos::reliable(10), Qos::latched(1)].map(Qos::profile);
        let qos = ActionServerQosPolicies {
            goal_service: service.clone(),
            result_service: service.clone(),
            cancel_service: service,
            feedback_publisher: feedback,
            status_publisher: status,
        };
        let middleware = shared
            .with_node(|node| node.create_action_server(mapping, &parsed, &type_name, qos))?;
        let middleware = Rc::new(RefCell::new(middleware));
        let server = Rc::new(Self {
            shared: Rc::clone(shared),
            name,
            middleware: Rc::downgrade(&middleware),
            goals: RefCell::new(Goals::new()),
        });
        shared.spawn(async move {
            loop {
                let request =
                    poll_fn(|cx| next_request::<A>(&mut middleware.borrow_mut(), cx)).await;
                let turn = server.shared.share.turn().await;
                match request {
                    Request::Goal(asker, request) => {
                        if let Some(goal) = server.accept(asker, request) {
                            on_goal(goal, turn).await;
                        }
                    }
                    Request::Cancel(asker, request) => {
                        for id in server.cancel(asker, &request) {
                            on_cancel(id).await;
                        }
                    }
                    Request::Result(asker, request) => server.answer_result(asker, &request),
                    Request::Refused(error) => server.warn(&format!("request refused: {error}")),
                }
            }
        });
        Ok(())
    }

    fn accept(
        self: &Rc<Self>,
        asker: RmwRequestId,
        SendGoalRequest { goal_id, goal }: SendGoalRequest<Wire<A::Goal>>,
    ) -> Option<Goal<A>> {
        let Wire(request) = goal;
        let now = self.shared.clock.now();
        let accepted = self.is_finite("goal", &request)
            && self.goals.borrow_mut().accept(goal_id, now.clone());
        let response = SendGoalResponse {
            accepted,
            stamp: time(&now),
        };
        let name = format!("{}/_action/send_goal", self.name);
        let server = Rc::clone(self);
        self.answer(&name, asker, move |middleware| {
            middleware.send_goal_response(asker, response.clone())?;
            // The status after the answer, whenever that goes out.
            if accepted {
                server.goals.borrow_mut().answered(goal_id);
                server.publish_statuses();
            }
            Ok(())
        });
        if !accepted {
            self.warn(&format!("goal {goal_id:?} rejected"));
            return None;
        }
        Some(Goal {
            server: Rc::clone(self),
            id: goal_id,
            request,
        })
    }

    /// Answers a cancel request; returns the goals to cancel.
    fn cancel(
        self: &Rc<Self>,
        asker: RmwRequestId,
        request: &action_msgs::CancelGoalRequest,
    ) -> Vec<GoalId> {
        let cancelled = match readable(request) {
            Ok(request) => self.goals.borrow_mut().cancel(&request),
            Err(error) => {
                self.warn(&format!("cancel request refused: {error}"));
                Err(CancelGoalResponse::ERROR_REJECTED)
            }
        };
        use action_msgs::CancelGoalResponseEnum as Code;
        let (return_code, cancelled) = match cancelled {
            Ok(goals) => (Code::None, goals),
            Err(CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID) => (Code::UnknownGoal, Vec::new()),
            Err(CancelGoalResponse::ERROR_GOAL_TERMINATED) => (Code::GoalTerminated, Vec::new()),
            Err(_) => (Code::Rejected, Vec::new()),
        };
        let response = action_msgs::CancelGoalResponse {
            return_code,
            goals_canceling: cancelled
                .iter()
                .map(|(id, at)| goal_info(*id, at))
                .collect(),
        };
        let name = format!("{}/_action/cancel_goal", self.name);
        self.answer(&name, asker, move |middleware| {
            middleware.send_cancel_response(asker, response.clone())
        });
        self.publish_statuses();
        cancelled.into_iter().map(|(id, _)| id).collect()
    }

    fn answer_result(self: &Rc<Self>, asker: RmwRequestId, request: &GetResultRequest) {
        let outcome = self.goals.borrow_mut().outcome(request.goal_id, asker);
        match outcome {
            Outcome::Ended(status, result) => self.tell_result(asker, status, result),
            Outcome::Unknown => {
                self.tell_result(asker, GoalStatus::Unknown, A::Result::default());
            }
            Outcome::UnderWay => {}
        }
    }

    fn tell_result(self: &Rc<Self>, asker: RmwRequestId, status: GoalStatus, result: A::Result) {
        let response = GetResultResponse {
            status,
            result: Wire(result),
        };
        let name = format!("{}/_action/get_result", self.name);
        self.answer(&name, asker, move |middleware| {
            middleware.send_result(asker, response.clone())
        });
    }

    /// Sends an answer as soon as the client is known to receive it.
    fn answer(
        self: &Rc<Self>,
        service: &str,
        asker: RmwRequestId,
        send: impl Fn(&Middleware<A>) -> Result<(), WriteError<()>> + 'static,
    ) {
        let middleware = Weak::clone(&self.middleware);
        answers::answer(&self.shared, service, asker, move || {
            match middleware.upgrade() {
                Some(middleware) => send(&middleware.borrow()),
                None => Ok(()), // The node is shutting down.
            }
        });
    }

    fn publish_statuses(&self) {
        let Some(middleware) = self.middleware.upgrade() else {
            return; // The node is shutting down.
        };
        let goals = self.goals.borrow();
        let status_list = goals
            .statuses()
            .map(|(id, at, status)| action_msgs::GoalStatus {
                goal_info: goal_info(id, &at),
                status,
            });
        let array = action_msgs::GoalStatusArray {
            status_list: status_list.collect(),
        };
        let sent = middleware.borrow().send_goal_statuses(array);
        self.warn_of(sent);
    }

    fn is_finite<M: Message>(&self, what: &str, message: &M) -> bool {
        match message.first_non_finite() {
            None => true,
            Some(field) => {
                self.warn(&format!("{what} refused: {field} is not finite"));
                false
            }
        }
    }

    fn warn_of<E: std::fmt::Debug>(&self, sent: Result<(), E>) {
        if let Err(error) = sent {
            self.warn(&format!("not sent: {error:?}"));
        }
    }

    fn warn(&self, text: &str) {
        self.shared.warn(&self.name, text);
    }
}

/// The next request of any of the three services.
fn next_request<A: Action>(
    middleware: &mut Middleware<A>,
    cx: &mut Context<'_>,
) -> Poll<Request<A>> {
    let goal = received(middleware.goal_server(), cx, Request::Goal);
    if goal.is_ready() {
        return goal;
    }
    let cancel = received(middleware.cancel_server(), cx, Request::Cancel);
    if cancel.is_ready() {
        return cancel;
    }
    received(middleware.result_server(), cx, Request::Result)
}

/// The next request of one service. The waker stays with its reader, so the stream need not outlive the call; the stream never ends.
fn received<A: Action, Asked, Answer>(
    server: &Server<Asked, Answer>,
    cx: &mut Context<'_>,
    request: impl FnOnce(RmwRequestId, Asked) -> Request<A>,
) -> Poll<Request<A>>
where
    Asked: ros2_client::Message + Clone + 'static,
    Answer: ros2_client::Message + 'static,
{
    match server.receive_request_stream().poll_next_unpin(cx) {
        Poll::Ready(Some(Ok((asker, message)))) => Poll::Ready(request(asker, message)),
        Poll::Ready(Some(Err(error))) => Poll::Ready(Request::Refused(error)),
        Poll::Ready(None) | Poll::Pending => Poll::Pending,
    }
}

/// Converts a request to a type with readable fields, because the fields of the middleware's type are private.
fn readable(request: &action_msgs::CancelGoalRequest) -> serde_json::Result<CancelGoalRequest> {
    serde_json::from_value(serde_json::to_value(request)?)
}

fn goal_info(goal_id: GoalId, accepted: &Time) -> GoalInfo {
    let stamp = time(accepted);
    GoalInfo { goal_id, stamp }
}

fn time(time: &Time) -> builtin_interfaces::Time {
    builtin_interfaces::Time::from_nanos(time.nanos())
}

/// Type of the action for the middleware; announces the type hashes of all its endpoints.
pub(crate) fn announce_action<A: Action>() -> Result<ActionTypeName> {
    fn announce_service<S: Service>() {
        announce_type_hash(S::REQUEST_DDS_TYPE_NAME, S::TYPE_HASH);
        announce_type_hash(S::RESPONSE_DDS_TYPE_NAME, S::TYPE_HASH);
    }
    fn announce_message<M: Message>() {
        announce_type_hash(M::DDS_TYPE_NAME, M::TYPE_HASH);
    }
    announce_service::<A::SendGoal>();
    announce_service::<A::GetResult>();
    announce_service::<CancelGoal>();
    announce_message::<A::FeedbackMessage>();
    announce_message::<GoalStatusArray>();
    match A::TYPE_NAME.split('/').collect::<Vec<_>>()[..] {
        [package, "action", name] => Ok(ActionTypeName::new(package, name)),
        _ => Err(Error::TypeName {
            name: A::TYPE_NAME.to_owned(),
            form: "package/action/Name is expected",
        }),
    }
}
