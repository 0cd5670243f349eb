//! A node on one page: sends back each number it hears, times a parameter.
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
use planesman_parameters::{Declaration, Values};

enum Event {
    Input(Float64),
    Mute(SetBoolRequest, Responder<SetBool>),
    Beat,
    Parameters(Values),
}

fn main() -> ExitCode {
    planesman_node::exit_code("doubler", run)
}

fn run() -> anyhow::Result<()> {
    let spec = NodeSpec {
        name: "doubler",
        namespace: "/",
        declarations: vec![
            Declaration::new("gain", 2.0, "output over input").range(0.0, 10.0),
            Declaration::new("offset", 0.0, "output at input 0")
                .unit("m")
                .range(-10.0, 10.0),
        ],
        validate: |values| {
            if values.double("gain") == 0.0 && values.double("offset") == 0.0 {
                return Err("gain and offset must not both be 0".to_owned());
            }
            Ok(())
        },
        on_parameters: Event::Parameters,
    };
    let rt = Runtime::start(spec, args::from_environment()?)?;
    let mut values = rt.values();
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
                let data = values.double("gain") * data + values.double("offset");
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
            Event::Parameters(new) => values = new,
        }
        Ok(Flow::Continue)
    })
}
