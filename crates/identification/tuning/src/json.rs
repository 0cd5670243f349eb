//! A tuning as JSON, for `--json`; infinite numbers are `null`.

use serde_json::{Value, json};

use crate::robustness::{Distribution, MISSED};
use crate::tune::Tuning;

impl Tuning {
    /// The tuning as JSON, without the responses.
    #[must_use]
    pub fn as_json(&self) -> Value {
        let finite = |value: f64| Some(value).filter(|it| it.is_finite());
        let spread = |of: &Distribution| {
            json!({
                "model": finite(of.model),
                "q05": finite(of.quantile(MISSED)),
                "q50": finite(of.quantile(0.5)),
                "q95": finite(of.quantile(1.0 - MISSED)),
            })
        };
        let gains = &self.controller;
        let (robustness, steps) = (&self.robustness, &self.steps);
        json!({
            "input": self.model.input,
            "output": self.model.output,
            "model": self.model.description,
            "notes": self.notes,
            "method": self.method.name(),
            "why": self.why,
            "period": self.sampling.tick,
            "computing_delay": self.sampling.computing_delay,
            "reduced": self.reduced.as_ref().map(|it| json!({
                "gain": it.gain,
                "integrators": it.integrators(),
                "time_constants": it.time_constants.iter().copied().filter(|tau| tau.is_finite()).collect::<Vec<_>>(),
                "delay": it.delay,
            })),
            "pace": self.pace.map(|(name, value)| json!({"name": name, "value": value})),
            "parallel": {"kp": gains.kp, "ki": gains.ki, "kd": gains.kd, "filter": gains.filter},
            "ideal": {"k": gains.kp, "ti": finite(gains.ti()), "td": gains.td()},
            "limits": {
                "phase_margin": self.limits.phase.to_degrees(),
                "gain_margin": 20.0 * libm::log10(self.limits.gain),
                "ms": self.limits.sensitivity,
                "are_kept": self.keeps_limits(),
            },
            "draws": robustness.draws.len(),
            "unstable": robustness.unstable(),
            "phase_margin": spread(&robustness.phase()),
            "gain_margin": spread(&robustness.gain()),
            "ms": spread(&robustness.sensitivity()),
            "crossover": spread(&robustness.crossover()),
            "step": steps.step,
            "overshoot": spread(&steps.overshoot),
            "settling_time": spread(&steps.settling),
            "peak_input": spread(&steps.peak_input),
            "travel": spread(&steps.travel),
            "at_limit": spread(&steps.at_limit),
            "load_error": spread(&steps.load_error),
            "causes": self.causes.iter().map(|it| json!({
                "name": it.name,
                "unit": it.unit,
                "value": it.value,
                "deviation": it.deviation,
                "share": it.share,
                "experiment": it.experiment,
            })).collect::<Vec<_>>(),
        })
    }
}
