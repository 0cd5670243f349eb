//! A node on one page: publishes each received number, times a parameter.
//!
//! ```sh
//! cargo run -p planesman_node --example doubler -- --ros-args -p gain:=3.0 -r __ns:=/demo
//! ros2 topic pub --once /demo/input std_msgs/msg/Float64 '{data: 21.0}'
//! ```

use std::{process::ExitCode, time::Duration};

use planesman_msgs::{
    std_msgs::msg::Float64,
    std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse},
};
use planesman_node::{Flow, Level, NodeSpec, Qos, Responder, Runtime, args};
use planesman_parameters::Parameters;

/// The parameters that `ros2 param` shows.
#[derive(Parameters)]
struct Doubler {
    /// output over input
    #[parameter(default = 2.0, range = 0.0..=10.0)]
    gain: f64,
    /// output at input 0
    #[parameter(default = 0.0, unit = "m", range = -10.0..=10.0)]
    offset: f64,
}

enum Event {
    Input(Float64),
    Mute(SetBoolRequest, Responder<SetBool>),
    Beat,
    Parameters(Doubler),
}

fn main() -> ExitCode {
    planesman_node::exit_code("doubler", run)
}

fn run() -> anyhow::Result<()> {
    let spec = NodeSpec {
        name: "doubler",
        namespace: "/",
        validate: |parameters: &Doubler| {
            if parameters.gain == 0.0 && parameters.offset == 0.0 {
                return Err("gain and offset must not both be 0".into());
            }
            Ok(())
        },
        on_parameters: Event::Parameters,
    };
    let (rt, mut parameters) = Runtime::start(spec, args::from_environment()?)?;
    let mut muted = false;
    let output = rt.publisher::<Float64>("output", Qos::reliable(1000))?;
    let beat = rt.publisher::<Float64>("~/beat", Qos::sensor())?;
    rt.subscribe("input", Qos::reliable(1000), Event::Input)?;
    rt.serve("~/mute", Event::Mute)?;
    rt.every(Duration::from_millis(50), || Event::Beat);
    rt.run(|rt, event| {
        match event {
            Event::Input(_) if muted => {}
            Event::Input(Float64 { data }) => {
                let data = parameters.gain * data + parameters.offset;
                output.publish(&Float64 { data });
            }
            Event::Beat => {
                let data = rt.now().nanos() as f64 * 1e-9;
                beat.publish(&Float64 { data });
            }
            Event::Mute(request, responder) => {
                muted = request.data;
                let level = if muted { Level::Warn } else { Level::Ok };
                rt.set_status("output", level, if muted { "muted" } else { "ok" }, &[]);
                responder.answer(SetBoolResponse {
                    success: true,
                    message: String::new(),
                });
            }
            Event::Parameters(changed) => parameters = changed,
        }
        Ok(Flow::Continue)
    })
}
