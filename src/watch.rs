//! `planesman watch`: shows the running vehicles of the DDS domain on a page in the browser.

use std::net::{IpAddr, Ipv4Addr};

use anyhow::Result;
use clap::Args;
use planesman_identification::Reading;
use planesman_linear::{Complex, ComplexFunctions as _, by_decay, is_sampling_artefact};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_node::{BoxedError, args};
use planesman_parameters::{Parameters as _, Value};
use planesman_plant::PlantParameters;
use planesman_watch::{ModelFunctions, Named, Options, Pole, Vehicle};

use crate::nodes::end_with_launcher;
use planesman_flight::summary::truth_of;

/// Arguments of `planesman watch`.
#[derive(Args, Clone, Debug)]
pub struct WatchArgs {
    /// Port of the page; 0: any free port
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// Address to listen on; the page needs the token in the printed address
    #[arg(long, value_name = "ADDR", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// Do not open the browser
    #[arg(long)]
    no_open: bool,
    /// ROS arguments, such as --ros-args --log-level warn
    #[arg(last = true)]
    ros: Vec<String>,
}

/// Serves the page until the process is requested to stop.
///
/// # Errors
/// A refused argument, an address that cannot be listened on, a failing start of the middleware.
pub fn run(watch: &WatchArgs) -> Result<()> {
    end_with_launcher();
    let options = Options {
        listen: watch.listen,
        port: watch.port,
        open: !watch.no_open,
    };
    let models = ModelFunctions { poles, vehicle };
    Ok(planesman_watch::run(
        options,
        models,
        args::only(watch.ros.clone())?,
    )?)
}

/// The poles of an estimate, slowest first, with standard deviations if the covariance allows them.
fn poles(model: &ModelEstimate) -> Vec<Pole> {
    let estimate = planesman_identifier::estimate_of(model);
    let uncertain = estimate.and_then(|it| Reading::new(&it, 0).continuous_poles().ok());
    let mut poles: Vec<Pole> = match uncertain {
        Some(poles) => poles
            .iter()
            .map(|pole| Pole {
                re: pole.value.re,
                im: pole.value.im,
                re_sd: pole.real_deviation(),
                im_sd: pole.imaginary_deviation(),
                artefact: false,
            })
            .collect(),
        None => {
            let parts = model.s_poles_re.iter().zip(&model.s_poles_im);
            parts.map(|(re, im)| certain(*re, *im)).collect()
        }
    };
    for pole in &mut poles {
        let z = (Complex::new(pole.re, pole.im) * model.sample_time).exp();
        pole.artefact = model.sample_time > 0.0 && is_sampling_artefact(z);
    }
    let place = |pole: &Pole| Complex::new(pole.re, pole.im);
    poles.sort_by(|a, b| {
        let is_artefact = a.artefact.cmp(&b.artefact);
        is_artefact.then(by_decay(&place(a), &place(b)))
    });
    poles
}

fn certain(re: f64, im: f64) -> Pole {
    Pole {
        re,
        im,
        re_sd: 0.0,
        im_sd: 0.0,
        artefact: false,
    }
}

/// The vehicle of a `plant_sim` with these parameters.
fn vehicle(parameters: &[Named]) -> Result<Vehicle, BoxedError> {
    let default = PlantParameters::default();
    let values = default.values();
    let known: Vec<(&str, Value)> = parameters
        .iter()
        .filter(|(name, _)| values.declaration(name).is_some())
        .map(|(name, value)| (name.as_str(), value.clone()))
        .collect();
    let parameters = default.with(&known)?;
    let truth = truth_of(&parameters, parameters.tick)?;
    let poles = truth.poles.iter().map(|it| certain(it.re, it.im)).collect();
    Ok(Vehicle {
        name: parameters.vehicle,
        bottom: parameters.environment.bottom,
        poles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicles_true_poles_follow_from_its_parameters() {
        let default = vehicle(&[]).expect("the report's vehicle");
        assert_eq!(default.name, "brunner");
        assert_eq!(default.poles.len(), 3);
        let speed = ("speed".to_owned(), Value::Double(0.6096));
        let foreign = ("use_sim_time".to_owned(), Value::Bool(true));
        let faster = vehicle(&[speed, foreign]).expect("the same at twice the speed");
        assert_ne!(faster.poles, default.poles);
        let missing = ("vehicle".to_owned(), Value::from("no/such.yaml"));
        assert!(vehicle(&[missing]).is_err());
    }

    #[test]
    fn an_estimate_without_a_covariance_has_poles_without_deviations() {
        let model = ModelEstimate {
            s_poles_re: vec![-1.0, -0.3],
            s_poles_im: vec![0.0, 0.1],
            ..ModelEstimate::default()
        };
        assert_eq!(poles(&model), [certain(-0.3, 0.1), certain(-1.0, 0.0)]);
        let sampled = ModelEstimate {
            sample_time: 4.0,
            ..model
        };
        let artefacts: Vec<bool> = poles(&sampled).iter().map(|it| it.artefact).collect();
        assert_eq!(artefacts, [false, true]);
    }
}
