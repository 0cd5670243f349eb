//! Many vehicles of one kind at once: their values are stored side by side and stepped together.

use super::equations::State;
use super::lanes::Lanes;
use super::simulate::runge_kutta_under;
use super::vehicle::Vehicle;
use super::water::Water;

/// Number of vehicles in a group that is stepped together.
const WIDTH: usize = 8;

/// Vehicles of one kind, each with its own state, inputs and water. Each vehicle moves exactly as it would alone, to the last bit.
#[derive(Clone, Debug)]
pub struct Batch<'a> {
    vehicle: &'a Vehicle,
    count: usize,
    /// Groups of [`WIDTH`]; the last group is filled with copies of its first vehicle.
    groups: Vec<Group>,
}

#[derive(Clone, Debug)]
struct Group {
    state: State<Lanes<WIDTH>>,
    inputs: Vec<Lanes<WIDTH>>,
    water: Water<Lanes<WIDTH>>,
}

impl<'a> Batch<'a> {
    /// Creates vehicles in these states, with zero inputs in water at rest.
    #[must_use]
    pub fn new(vehicle: &'a Vehicle, states: &[State]) -> Self {
        let groups = states.chunks(WIDTH).map(|chunk| {
            let rows: [[f64; 13]; WIDTH] =
                std::array::from_fn(|lane| chunk.get(lane).unwrap_or(&chunk[0]).row());
            Group {
                state: State::of_row(std::array::from_fn(|i| Lanes(rows.map(|row| row[i])))),
                inputs: vec![Lanes([0.0; WIDTH]); vehicle.parts().inputs.len()],
                water: Water::at_rest(),
            }
        });
        Self {
            vehicle,
            count: states.len(),
            groups: groups.collect(),
        }
    }

    /// Number of vehicles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no vehicles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// State of vehicle `k`.
    ///
    /// # Panics
    /// If there is no vehicle `k`.
    #[must_use]
    pub fn state(&self, k: usize) -> State {
        assert!(k < self.count);
        let row = self.groups[k / WIDTH].state.row();
        State::of_row(row.map(|x| x.0[k % WIDTH]))
    }

    /// Sets the inputs of vehicle `k`, in the order of [`super::Parts::inputs`]; missing inputs stay unchanged.
    ///
    /// # Panics
    /// If there is no vehicle `k`.
    pub fn set_inputs(&mut self, k: usize, inputs: &[f64]) {
        assert!(k < self.count);
        for (of, input) in self.groups[k / WIDTH].inputs.iter_mut().zip(inputs) {
            of.0[k % WIDTH] = *input;
        }
    }

    /// Sets the water around vehicle `k`. Surface and bottom are common to its group of eight; the last call determines them.
    ///
    /// # Panics
    /// If there is no vehicle `k`.
    pub fn set_water(&mut self, k: usize, water: &Water<f64>) {
        assert!(k < self.count);
        let (of, lane) = (&mut self.groups[k / WIDTH].water, k % WIDTH);
        (of.has_surface, of.bottom) = (water.has_surface, water.bottom);
        for (to, from) in [
            (&mut of.velocity, water.velocity),
            (&mut of.acceleration, water.acceleration),
            (&mut of.of_water, water.of_water),
        ] {
            for i in 0..3 {
                to[i].0[lane] = from[i];
            }
        }
    }

    /// Advances by `steps` steps of `dt` \[s\] with the classical Runge-Kutta method; inputs and water are constant.
    pub fn advance(&mut self, steps: u32, dt: f64) {
        for group in &mut self.groups {
            let held = self.vehicle.held(&group.inputs);
            for _ in 0..steps {
                group.state =
                    runge_kutta_under(self.vehicle, &group.state, &held, &group.water, dt);
            }
        }
    }

    /// Splits the vehicles into parts of about `count` each, for different threads.
    #[must_use]
    pub fn split(self, count: usize) -> Vec<Self> {
        let size = count.div_ceil(WIDTH).max(1);
        let (vehicle, mut left) = (self.vehicle, self.count);
        let mut groups = self.groups.into_iter().peekable();
        let mut parts = Vec::new();
        while groups.peek().is_some() {
            let of: Vec<Group> = groups.by_ref().take(size).collect();
            let count = left.min(of.len() * WIDTH);
            left -= count;
            parts.push(Self {
                vehicle,
                count,
                groups: of,
            });
        }
        parts
    }
}
