//! Scenarios, and their simulation in this process: the whole flight, or tick by tick, also with a controller of the caller.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use planesman_flight::compose::Loop as Composed;
use planesman_flight::parts::{Law, PartError, Parts, dive};
use planesman_flight::scenario::Scenario;
use planesman_flight::sink::{COLUMNS, McapSink};
use planesman_msgs::planesman_msgs::msg::{ControlState, PlaneCommand, VehicleState};
use planesman_parameters::Value;
use pyo3::prelude::*;

use crate::array::array;
use crate::error::{PlanesmanError, raised, released};

/// A column of a flight's table.
type Column<'py> = (&'static str, Bound<'py, PyAny>);

/// The text of a scenario with the given changes, checked as the nodes do. `given` is a name, a path, or the text itself.
#[pyfunction]
pub(crate) fn scenario(
    given: &str,
    is_text: bool,
    changes: Vec<String>,
    duration: Option<f64>,
    tick: Option<f64>,
    seed: Option<u32>,
) -> PyResult<String> {
    let loaded = match is_text {
        true => Scenario::parse_with(given, Path::new(""), &changes, "scenario"),
        false => Scenario::load_with(given, &changes),
    };
    let timed = loaded.and_then(|it| it.timed(duration, tick, seed));
    Ok(timed.map_err(raised)?.to_yaml())
}

/// Simulates a scenario. Returns the columns of the flight's table, `NAME [UNIT]`, with one number per tick. With `bag`, every
/// message is also written to one MCAP file.
#[pyfunction]
pub(crate) fn fly<'py>(
    py: Python<'py>,
    scenario: &str,
    bag: Option<PathBuf>,
    namespace: &str,
) -> PyResult<Vec<Column<'py>>> {
    let columns = released(py, || {
        let scenario = Scenario::parse(scenario)?;
        let ticks = scenario.ticks() as usize;
        let mut columns = vec![Vec::with_capacity(ticks); COLUMNS.len()];
        let mut sink = bag
            .map(|path| McapSink::create(&path, namespace, false))
            .transpose()?;
        for tick in Composed::new(&scenario)? {
            let tick = tick?;
            for (column, (_, _, of)) in columns.iter_mut().zip(COLUMNS) {
                column.push(of(&tick));
            }
            if let Some(sink) = &mut sink {
                tick.put_into(sink)?;
            }
        }
        sink.map(McapSink::finish).transpose()?;
        Ok(columns)
    })?;
    let named = COLUMNS.iter().zip(columns);
    named
        .map(|((name, ..), numbers)| Ok((*name, array(py, numbers)?)))
        .collect()
}

/// A number of the state: its name with unit, and the function that reads it.
type State = (&'static str, fn(&VehicleState) -> f64);

/// The numbers of the state, in the order of the arrays.
pub(crate) const STATES: [State; 13] = [
    ("depth [m]", |it| it.depth),
    ("depth_rate [m/s]", |it| it.depth_rate),
    ("distance [m]", |it| it.distance),
    ("cross_track [m]", |it| it.cross_track),
    ("roll [rad]", |it| it.roll),
    ("roll_rate [rad/s]", |it| it.roll_rate),
    ("pitch [rad]", |it| it.pitch),
    ("pitch_rate [rad/s]", |it| it.pitch_rate),
    ("yaw [rad]", |it| it.yaw),
    ("yaw_rate [rad/s]", |it| it.yaw_rate),
    ("surge [m/s]", |it| it.surge),
    ("heave [m/s]", |it| it.heave),
    ("dive_planes [rad]", |it| it.dive_planes),
];

fn numbers<'py>(py: Python<'py>, state: &VehicleState) -> PyResult<Bound<'py, PyAny>> {
    array(py, STATES.iter().map(|(_, of)| of(state)).collect())
}

/// The names of [`STATES`].
#[pyfunction]
pub(crate) fn states() -> Vec<&'static str> {
    STATES.iter().map(|(name, _)| *name).collect()
}

/// A Python function of time and state that replaces a control law.
struct Function {
    function: Py<PyAny>,
    depth_setpoint: f64,
    /// The exception that the function raised.
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Law for Function {
    fn on_state(
        &mut self,
        state: &VehicleState,
    ) -> Result<(PlaneCommand, ControlState), PartError> {
        let time = state.header.stamp.nanos() as f64 * 1e-9;
        let planes = Python::attach(|py| -> PyResult<Vec<f64>> {
            let answer = self.function.bind(py).call1((time, numbers(py, state)?))?;
            match answer.extract::<f64>() {
                Ok(planes) => Ok(vec![planes]),
                Err(_) => answer.extract(),
            }
        });
        let planes = planes.map_err(|error| {
            let text = error.to_string();
            *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            text
        })?;
        let [dive_planes, rest @ ..] = &planes[..] else {
            return Err("the controller must return at least one plane angle".into());
        };
        if rest.len() > 4 {
            return Err(
                "the controller may return at most five values: dive_planes, bow_stern_differential, roll_differential, rudder, thrust"
                    .into(),
            );
        }
        let (mut command, mut control) = dive(state, *dive_planes, self.depth_setpoint);
        let of = |place: usize| rest.get(place).copied().unwrap_or(0.0);
        command.bow_stern_differential = of(0);
        command.roll_differential = of(1);
        command.rudder = of(2);
        command.thrust = of(3);
        control.bow_stern_differential = of(0);
        control.roll_differential = of(1);
        control.rudder = of(2);
        control.thrust = of(3);
        Ok((command, control))
    }
}

/// A simulated control loop that Python steps tick by tick.
#[pyclass(frozen, module = "planesman._native")]
pub(crate) struct Loop {
    inner: Mutex<(Composed, Option<McapSink>)>,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Loop {
    /// Calls `work` with the loop; refused while the loop's own controller is running.
    fn with<T>(
        &self,
        work: impl FnOnce(&mut (Composed, Option<McapSink>)) -> planesman_flight::Result<T>,
    ) -> PyResult<T> {
        let mut inner = self.inner.try_lock().map_err(|_| {
            PlanesmanError::new_err(
                "the controller cannot step the loop, because the loop is already running a step",
            )
        })?;
        work(&mut inner).map_err(|error| {
            let own = self
                .raised
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .take();
            own.unwrap_or_else(|| raised(error))
        })
    }
}

#[pymethods]
impl Loop {
    #[new]
    fn new(
        scenario: &str,
        controller: Option<Py<PyAny>>,
        bag: Option<PathBuf>,
        namespace: &str,
    ) -> PyResult<Self> {
        let seen = Arc::new(Mutex::new(None));
        let begun = || -> planesman_flight::Result<_> {
            let scenario = Scenario::parse(scenario)?;
            let mut parts = Parts::default();
            if let Some(function) = controller {
                let values = scenario.values("depth_controller")?;
                let depth_setpoint = match values.get("depth_setpoint") {
                    Some(Value::Double(setpoint)) => *setpoint,
                    _ => 0.0,
                };
                let seen = Arc::clone(&seen);
                parts = parts.with_law(move |_| {
                    Ok::<_, PartError>(Function {
                        function: Python::attach(|py| function.clone_ref(py)),
                        depth_setpoint,
                        raised: Arc::clone(&seen),
                    })
                });
            }
            let composed = Composed::of_parts(&parts, &scenario)?;
            let sink = bag.map(|path| McapSink::create(&path, namespace, false));
            Ok((composed, sink.transpose()?))
        };
        let inner = Mutex::new(begun().map_err(raised)?);
        Ok(Self {
            inner,
            raised: seen,
        })
    }

    /// The numbers of the current state.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.with(|(composed, _)| Ok(composed.state()))?;
        numbers(py, &state)
    }

    /// The current time, s.
    fn time(&self) -> PyResult<f64> {
        self.with(|(composed, _)| Ok(composed.state().header.stamp.nanos() as f64 * 1e-9))
    }

    /// Whether the scenario's duration has passed.
    fn is_over(&self) -> PyResult<bool> {
        self.with(|(composed, _)| Ok(composed.is_over()))
    }

    /// Simulates one tick.
    fn step(&self) -> PyResult<()> {
        self.with(|(composed, sink)| match sink {
            Some(sink) => composed.tick()?.put_into(sink),
            None => composed.step().map(drop),
        })
    }

    /// Completes the bag and moves it to its path.
    fn close(&self) -> PyResult<()> {
        self.with(|(_, sink)| sink.take().map_or(Ok(()), McapSink::finish))
    }
}
