// Many vehicles of six degrees of freedom, one after the other, by Runge-Kutta of fourth order: the equations of cases/six_dof.py as matrices.
//
// Reads from its input, all in SI units: M_RB, M_A, the inverse of their sum, D, Q, L by rows; weight, buoyancy; centres of gravity and buoyancy;
// the current; the first vehicle's state, vehicle k of n begins k/n m/s faster; n, steps of a segment, their length; how many vehicles are looked at and which; how
// many segments, and of each tau and f. Prints a line of JSON: CPU time of one step of one vehicle [s], and the states looked at after each segment.

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <vector>

using Three = std::array<double, 3>;
using Six = std::array<double, 6>;
using State = std::array<double, 13>;
using Matrix = std::array<Six, 6>;

struct Vehicle {
    Matrix rigid, added, inverse, linear, quadratic, lift;
    double weight, buoyancy;
    Three gravity, buoyant;
};

struct Held {
    Six tau, f;
};

static Six product(const Matrix &m, const Six &x) {
    Six y{};
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) y[i] += m[i][j] * x[j];
    return y;
}

static Three cross(const Three &a, const Three &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

static Six coriolis(const Matrix &inertia, const Six &nu) {
    const Six m = product(inertia, nu);
    const Three v{nu[0], nu[1], nu[2]}, w{nu[3], nu[4], nu[5]}, p{m[0], m[1], m[2]}, h{m[3], m[4], m[5]};
    const Three force = cross(w, p), first = cross(v, p), second = cross(w, h);
    return {force[0], force[1], force[2], first[0] + second[0], first[1] + second[1], first[2] + second[2]};
}

static State rates(const Vehicle &vehicle, const Three &water, const Held &held, const State &x) {
    const double a = x[3], b = x[4], c = x[5], d = x[6];
    const Six nu{x[7], x[8], x[9], x[10], x[11], x[12]};
    const Three w{nu[3], nu[4], nu[5]};
    const double s = 2 / (a * a + b * b + c * c + d * d);
    const double r[3][3] = {
        {1 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c)},
        {s * (b * c + a * d), 1 - s * (b * b + d * d), s * (c * d - a * b)},
        {s * (b * d - a * c), s * (c * d + a * b), 1 - s * (b * b + c * c)},
    };
    Three current{};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) current[j] += r[i][j] * water[i];
    Six through = nu, square;
    for (int i = 0; i < 3; ++i) through[i] -= current[i];
    for (int i = 0; i < 6; ++i) square[i] = std::abs(through[i]) * through[i];
    const Three carried = cross(current, w);
    const Six rigid = coriolis(vehicle.rigid, nu), added = coriolis(vehicle.added, through);
    const Six linear = product(vehicle.linear, through), quadratic = product(vehicle.quadratic, square);
    const Six lift = product(vehicle.lift, through);
    const Six follows = product(vehicle.added, {carried[0], carried[1], carried[2], 0, 0, 0});
    const Three weight{vehicle.weight * r[2][0], vehicle.weight * r[2][1], vehicle.weight * r[2][2]};
    const Three buoyancy{-vehicle.buoyancy * r[2][0], -vehicle.buoyancy * r[2][1], -vehicle.buoyancy * r[2][2]};
    const Three by_weight = cross(vehicle.gravity, weight), by_buoyancy = cross(vehicle.buoyant, buoyancy);
    const double u = through[0];
    Six force;
    for (int i = 0; i < 6; ++i)
        force[i] = held.tau[i] + u * lift[i] + u * u * held.f[i] - rigid[i] - added[i] - linear[i] - quadratic[i] + follows[i];
    for (int i = 0; i < 3; ++i) {
        force[i] += weight[i] + buoyancy[i];
        force[i + 3] += by_weight[i] + by_buoyancy[i];
    }
    const Six rate = product(vehicle.inverse, force);
    State out;
    for (int i = 0; i < 3; ++i) out[i] = r[i][0] * nu[0] + r[i][1] * nu[1] + r[i][2] * nu[2];
    out[3] = -(b * w[0] + c * w[1] + d * w[2]) / 2;
    out[4] = (a * w[0] + c * w[2] - d * w[1]) / 2;
    out[5] = (a * w[1] + d * w[0] - b * w[2]) / 2;
    out[6] = (a * w[2] + b * w[1] - c * w[0]) / 2;
    for (int i = 0; i < 6; ++i) out[7 + i] = rate[i];
    return out;
}

static State along(const State &x, const State &rate, double h) {
    State moved = x;
    for (int i = 0; i < 13; ++i) moved[i] += h * rate[i];
    return moved;
}

static State step(const Vehicle &vehicle, const Three &water, const Held &held, const State &x, double h) {
    const State k1 = rates(vehicle, water, held, x);
    const State k2 = rates(vehicle, water, held, along(x, k1, h / 2));
    const State k3 = rates(vehicle, water, held, along(x, k2, h / 2));
    const State k4 = rates(vehicle, water, held, along(x, k3, h));
    State next = x;
    for (int i = 0; i < 13; ++i) next[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    const double length = std::sqrt(next[3] * next[3] + next[4] * next[4] + next[5] * next[5] + next[6] * next[6]);
    for (int i = 3; i < 7; ++i) next[i] /= length;
    return next;
}

static double number() {
    double x = 0;
    std::cin >> x;
    return x;
}

template <std::size_t N> static void read(std::array<double, N> &into) {
    for (double &x : into) x = number();
}

static double processor_time() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return now.tv_sec + now.tv_nsec * 1e-9;
}

int main() {
    Vehicle vehicle;
    for (Matrix *m : {&vehicle.rigid, &vehicle.added, &vehicle.inverse, &vehicle.linear, &vehicle.quadratic, &vehicle.lift})
        for (Six &row : *m) read(row);
    vehicle.weight = number();
    vehicle.buoyancy = number();
    Three water;
    State first;
    read(vehicle.gravity);
    read(vehicle.buoyant);
    read(water);
    read(first);
    const int count = number(), steps = number();
    const double h = number();
    std::vector<int> seen(static_cast<int>(number()));
    for (int &k : seen) k = number();
    std::vector<Held> segments(static_cast<int>(number()));
    for (Held &held : segments) {
        read(held.tau);
        read(held.f);
    }
    if (!std::cin) return 2;

    std::vector<std::vector<State>> ways(count);
    const double begun = processor_time();
    for (int k = 0; k < count; ++k) {
        State x = first;
        x[7] += static_cast<double>(k) / count;
        for (const Held &held : segments) {
            for (int i = 0; i < steps; ++i) x = step(vehicle, water, held, x, h);
            ways[k].push_back(x);
        }
    }
    const double one = (processor_time() - begun) / (static_cast<double>(count) * steps * segments.size());
    std::printf("{\"step\": %.4e, \"states\": [", one);
    for (std::size_t s = 0; s < seen.size(); ++s) {
        std::printf("%s[", s ? ", " : "");
        for (std::size_t i = 0; i < segments.size(); ++i) {
            std::printf("%s[", i ? ", " : "");
            for (int j = 0; j < 13; ++j) std::printf("%s%.17g", j ? ", " : "", ways[seen[s]][i][j]);
            std::printf("]");
        }
        std::printf("]");
    }
    std::printf("]}\n");
}
