// The dive of program T2, 60 s, by the equations of crates/vehicle/vehicle/src/dynamics.rs in the vertical plane and Runge-Kutta of fourth order.
//
// rk4 STEPS HEAVE_INERTIA PITCH_INERTIA Z_W Z_Q Z_DELTA M_W M_Q M_DELTA RESTORING SPEED PLANES, all in SI units; prints a line of JSON: the best
// time [s] of 50 dives of so many steps with every state kept, pitch [rad] and depth [m] after 10 s, and depth [m] at the end.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

struct Vehicle {
    double heave_inertia, pitch_inertia, z_w, z_q, z_delta, m_w, m_q, m_delta, restoring, speed;
};

// x, z, theta, w, q
using State = std::array<double, 5>;

static State rates(const Vehicle &v, const State &s, double delta) {
    const auto [x, z, theta, w, q] = s;
    const double sine = std::sin(theta), cosine = std::cos(theta);
    return {
        v.speed * cosine + w * sine,
        w * cosine - v.speed * sine,
        q,
        (v.z_w * w + v.z_q * q + v.z_delta * delta) / v.heave_inertia,
        (v.m_w * w + v.m_q * q + v.m_delta * delta - v.restoring * sine) / v.pitch_inertia,
    };
}

static State along(const State &s, const State &rate, double h) {
    State moved = s;
    for (std::size_t i = 0; i < s.size(); ++i) moved[i] += h * rate[i];
    return moved;
}

static State step(const Vehicle &v, const State &s, double delta, double h) {
    const State k1 = rates(v, s, delta);
    const State k2 = rates(v, along(s, k1, h / 2), delta);
    const State k3 = rates(v, along(s, k2, h / 2), delta);
    const State k4 = rates(v, along(s, k3, h), delta);
    State next = s;
    for (std::size_t i = 0; i < s.size(); ++i) next[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return next;
}

int main(int argc, char **argv) {
    if (argc != 13) return 2;
    const int steps = std::atoi(argv[1]);
    std::array<double, 11> given;
    for (std::size_t i = 0; i < given.size(); ++i) given[i] = std::atof(argv[i + 2]);
    const Vehicle v{given[0], given[1], given[2], given[3], given[4], given[5], given[6], given[7], given[8], given[9]};
    const double planes = given[10], h = 60.0 / steps;
    const int neutral = steps / 6;

    double shortest = 1e9;
    State after_10_s{};
    State end{};
    for (int round = 0; round < 50; ++round) {
        const auto start = std::chrono::steady_clock::now();
        std::vector<State> states;
        states.reserve(steps + 1);
        State s{};
        for (int k = 0; k < steps; ++k) {
            states.push_back(s);
            s = step(v, s, k < neutral ? planes : 0.0, h);
        }
        shortest = std::min(shortest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        after_10_s = states[neutral];
        end = s;
    }
    std::printf("{\"dive\": %.4e, \"pitch\": %.12f, \"depth\": %.12f, \"end\": %.12f}\n", shortest, after_10_s[2], after_10_s[1], end[1]);
}
