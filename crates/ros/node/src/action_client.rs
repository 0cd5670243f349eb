//! Action clients.

use crate::error::{Error, Result};
use std::{
    rc::{Rc, Weak},
    time::Duration,
};

use futures::StreamExt as _;
use planesman_msgs::{Action, Message, builtin_interfaces::msg::Time};
use ros2_client::{
    Name,
    action::{ActionClientQosPolicies, FeedbackMessage},
    action_msgs::CancelGoalResponseEnum,
    builtin_interfaces,
    service::ServiceMapping,
};
use smol::lock::Mutex;

use crate::{
    action_server::{GoalId, GoalStatus, announce_action},
    qos::Qos,
    service::{Wire, is_served, settle, within},
    shared::Shared,
    subscription::non_finite,
};

type Middleware<A> = ros2_client::action::ActionClient<
    Wire<<A as Action>::Goal>,
    Wire<<A as Action>::Result>,
    Wire<<A as Action>::Feedback>,
>;

/// Client of an action of another node. Clones share one connection.
pub struct ActionClient<A: Action> {
    shared: Rc<Shared>,
    /// The action's absolute name.
    name: Rc<str>,
    middleware: Weak<Middleware<A>>,
    /// Only one call of each service runs at a time, because the middleware gives a response to the caller that has waited longest.
    turns: Rc<[Mutex<()>; 3]>,
}

impl<A: Action> Clone for ActionClient<A> {
    fn clone(&self) -> Self {
        Self {
            shared: Rc::clone(&self.shared),
            name: Rc::clone(&self.name),
            middleware: Weak::clone(&self.middleware),
            turns: Rc::clone(&self.turns),
        }
    }
}

/// The services of an action, each with its own queue of calls.
#[derive(Clone, Copy)]
enum Part {
    Send,
    Cancel,
    Result,
}

impl Part {
    const ALL: [Self; 3] = [Self::Send, Self::Cancel, Self::Result];
}

impl<A: Action> ActionClient<A> {
    /// Opens the action, and passes on the feedback of all goals.
    pub(crate) fn open(
        shared: &Rc<Shared>,
        name: &str,
        mapping: ServiceMapping,
        mut on_feedback: impl AsyncFnMut(GoalId, A::Feedback) + 'static,
    ) -> Result<Self> {
        let name = shared.service_name(name)?;
        let type_name = announce_action::<A>()?;
        let parsed = Name::parse(&name).map_err(Error::name(&name))?;
        let [service, feedback, status] =
            [Qos::reliable(10), Qos::reliable(100), Qos::latched(1)].map(Qos::profile);
        let qos = ActionClientQosPolicies {
            goal_service: service.clone(),
            result_service: service.clone(),
            cancel_service: service,
            feedback_subscription: feedback,
            status_subscription: status,
        };
        let middleware: Middleware<A> = shared
            .with_node(|node| node.create_action_client(mapping, &parsed, &type_name, qos))?;
        let middleware = shared.keep(middleware);
        let client = Self {
            shared: Rc::clone(shared),
            name: name.into(),
            middleware: Rc::downgrade(&middleware),
            turns: Rc::default(),
        };
        for part in Part::ALL {
            shared.client_opened(&client.service(part));
        }
        let (ours, subject) = (Rc::clone(shared), Rc::clone(&client.name));
        shared.spawn(async move {
            let mut samples = Box::pin(middleware.feedback_subscription().async_stream());
            while let Some(sample) = samples.next().await {
                let refused = match sample {
                    Err(error) => error.to_string(),
                    Ok((FeedbackMessage { goal_id, feedback }, _)) => match non_finite(&feedback.0)
                    {
                        Some(reason) => reason,
                        None => {
                            on_feedback(goal_id, feedback.0).await;
                            continue;
                        }
                    },
                };
                ours.warn(&subject, &format!("feedback is refused: {refused}"));
            }
        });
        Ok(client)
    }

    /// Whether a server has been discovered.
    #[must_use]
    pub fn is_served(&self) -> bool {
        Part::ALL
            .into_iter()
            .all(|part| is_served(&self.shared, &self.service(part)))
    }

    /// Waits for a server, sends a goal, and returns its identifier; `None` if the goal was rejected.
    ///
    /// # Errors
    /// No answer within `timeout`, a number in the goal that is not finite, or an error of the middleware.
    pub async fn send(&self, goal: A::Goal, timeout: Duration) -> Result<Option<GoalId>> {
        if let Some(field) = goal.first_non_finite() {
            return Err(Error::NotFinite {
                service: self.name.to_string(),
                done: "asked",
                field,
            });
        }
        let (id, response) = self
            .call(Part::Send, timeout, async |middleware| {
                middleware.async_send_goal(Wire(goal)).await
            })
            .await?;
        Ok(response.accepted.then_some(id))
    }

    /// Waits for the result of a goal.
    ///
    /// # Errors
    /// No answer within `timeout`, or an error of the middleware.
    pub async fn result(&self, id: GoalId, timeout: Duration) -> Result<(GoalStatus, A::Result)> {
        let (status, Wire(result)) = self
            .call(Part::Result, timeout, async |middleware| {
                middleware.async_request_result(id).await
            })
            .await?;
        Ok((status, result))
    }

    /// Requests that a goal be cancelled; returns whether the server accepts.
    ///
    /// # Errors
    /// Same as [`ActionClient::result`].
    pub async fn cancel(&self, id: GoalId, timeout: Duration) -> Result<bool> {
        let at_any_time = builtin_interfaces::Time::from_nanos(Time::default().nanos());
        let response = self
            .call(Part::Cancel, timeout, async |middleware| {
                middleware.async_cancel_goal(id, at_any_time).await
            })
            .await?;
        Ok(response.return_code == CancelGoalResponseEnum::None)
    }

    async fn call<T, E: std::fmt::Debug>(
        &self,
        part: Part,
        timeout: Duration,
        ask: impl AsyncFnOnce(&Middleware<A>) -> Result<T, E>,
    ) -> Result<T> {
        let service = self.service(part);
        let call = async {
            settle(&self.shared, &service).await;
            let middleware = self.middleware.upgrade().ok_or(Error::ShutDown)?;
            let _turn = self.turns[part as usize].lock().await;
            ask(&middleware)
                .await
                .map_err(|e| Error::Failed(format!("{e:?}")))
        };
        within(&service, timeout, call).await
    }

    fn service(&self, part: Part) -> String {
        let service = match part {
            Part::Send => "send_goal",
            Part::Cancel => "cancel_goal",
            Part::Result => "get_result",
        };
        format!("{}/_action/{service}", self.name)
    }
}
