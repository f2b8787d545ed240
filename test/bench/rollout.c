/* One lap of the closed loop with the backstepping law, in plain C: the arithmetic of the package's rollout without its
   layers, to measure what those cost. The bench compares the results before it compares the times. */

#include <math.h>

#define PI 3.141592653589793

typedef struct { double decay, gain, travel; } Response;
typedef struct { Response first, middle, last, end; } Channel;

typedef struct {
    double mass, inertia, wheel_radius, wheel_separation, com_offset, wheel_inertia, viscous_friction;
    Channel linear, angular;
    double dt, position_dt;
    double k1, ti1, k2, ti2;
    double p, q, alpha, f, g;
    double motor_limit, command_limit;
} Loop;

typedef struct {
    double time, squared_position, squared_heading, max_position, log_longitudinal, log_lateral, log_heading;
    double peak_right, peak_left, highest_right, highest_left, power_right, power_left, energy;
} Totals;

static double wrap(double angle)
{
    if (-PI < angle && angle <= PI)
        return angle;
    double turn = fmod(angle, 2.0 * PI);
    if (turn < 0.0)
        turn += 2.0 * PI;
    return turn <= PI ? turn : turn - 2.0 * PI;
}

static double larger(double a, double b) { return b > a ? b : a; }
static double within(double limit, double x) { return limit <= 0.0 ? x : larger(-limit, x < limit ? x : limit); }

/* references: x, y, heading, v_r, omega_r of each position tick; state: x, y, heading, v, omega, wheel angles */
void roll(const Loop *loop, const double *references, double *state, int steps, int ratio, Totals *totals)
{
    const double r = loop->wheel_radius, R = 0.5 * loop->wheel_separation;
    const double sum_inertia = 0.5 * loop->mass * r * r + loop->wheel_inertia;
    const double difference_inertia = (loop->inertia + loop->mass * loop->com_offset * loop->com_offset) * r * r
        / (2.0 * R * R) + loop->wheel_inertia;
    double x = state[0], y = state[1], heading = state[2], v = state[3], omega = state[4];
    double right_angle = state[5], left_angle = state[6];
    double common = 0.0, differential = 0.0, command_v = 0.0, command_omega = 0.0;
    double e1 = 0.0, e2 = 0.0, e3 = 0.0;
    Totals t = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -INFINITY, -INFINITY, 0.0, 0.0, 0.0};

    for (int first = 0; first < steps; first += ratio) {
        {
            const double *reference = references + 5 * (first / ratio);
            const double c = cos(heading), s = sin(heading), dx = reference[0] - x, dy = reference[1] - y;
            e1 = c * dx + s * dy;
            e2 = -s * dx + c * dy;
            e3 = wrap(reference[2] - heading);
            const double sin_e3 = sin(e3), v_r = reference[3];
            double distance_squared = e1 * e1 + e2 * e2;
            if (distance_squared > 1e30)
                distance_squared = 1e30;
            const double u1 = -loop->alpha * loop->p * e1 * loop->f;
            const double u2 = -2.0 * loop->alpha * loop->p / loop->q * pow(distance_squared, loop->alpha - 1.0) * v_r
                * e2 - loop->q * sin_e3 * loop->g;
            command_v = v_r * cos(e3) - u1;
            command_omega = reference[4] - u2;
        }
        for (int k = first; k < first + ratio && k < steps; k++) {
        /* wheels and back, as the velocity law measures */
        const double right = (v + R * omega) / r, left = (v - R * omega) / r;
        const double linear_error = command_v - 0.5 * r * (right + left);
        const double angular_error = command_omega - 0.5 * r * (right - left) / R;
        const double lever = R / r;
        const double proportional_common = lever * loop->k1 * linear_error;
        const double proportional_differential = lever * loop->k2 * angular_error;
        const double both = proportional_common + common, apart = proportional_differential + differential;
        const double asked_right = both + apart, asked_left = both - apart;
        const double torque_right = within(loop->command_limit, asked_right);
        const double torque_left = within(loop->command_limit, asked_left);
        if (!((asked_right + asked_left - (torque_right + torque_left)) * linear_error > 0.0))
            common += proportional_common * loop->dt / loop->ti1;
        if (!((asked_right - asked_left - (torque_right - torque_left)) * angular_error > 0.0))
            differential += proportional_differential * loop->dt / loop->ti2;
        const double on_right = within(loop->motor_limit, torque_right);
        const double on_left = within(loop->motor_limit, torque_left);

        const double push = 0.5 * r * (on_right + on_left) / sum_inertia;
        const double twist = 0.5 * r * (on_right - on_left) / (R * difference_inertia);
        const Response *along[3] = {&loop->linear.first, &loop->linear.middle, &loop->linear.last};
        const Response *around[3] = {&loop->angular.first, &loop->angular.middle, &loop->angular.last};
        const double weights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
        double dx = 0.0, dy = 0.0;
        for (int i = 0; i < 3; i++) {
            const double forward = weights[i] * (along[i]->decay * v + along[i]->gain * push);
            const double direction = heading + around[i]->gain * omega + around[i]->travel * twist;
            dx += forward * cos(direction);
            dy += forward * sin(direction);
        }
        const Response *l = &loop->linear.end, *a = &loop->angular.end;
        const double distance = l->gain * v + l->travel * push, turn = a->gain * omega + a->travel * twist;
        x += loop->dt * dx;
        y += loop->dt * dy;
        heading = wrap(heading + turn);
        v = l->decay * v + l->gain * push;
        omega = a->decay * omega + a->gain * twist;
        right_angle += (distance + R * turn) / r;
        left_angle += (distance - R * turn) / r;
        if (!(fabs(x) < 1e6 && fabs(y) < 1e6 && fabs(v) < 1e6 && fabs(omega) < 1e6))
            goto end;

        const double power_right = on_right * right, power_left = on_left * left;
        t.peak_right = larger(t.peak_right, fabs(on_right));
        t.peak_left = larger(t.peak_left, fabs(on_left));
        t.highest_right = larger(t.highest_right, on_right);
        t.highest_left = larger(t.highest_left, on_left);
        t.power_right = larger(t.power_right, fabs(power_right));
        t.power_left = larger(t.power_left, fabs(power_left));
        t.energy += (larger(0.0, power_right) + larger(0.0, power_left)) * loop->dt;
        if (k == first) {
            const double squared = e1 * e1 + e2 * e2;
            t.time += loop->position_dt;
            t.squared_position += squared * loop->position_dt;
            t.squared_heading += e3 * e3 * loop->position_dt;
            t.max_position = larger(t.max_position, sqrt(squared));
            t.log_longitudinal += log1p(fabs(e1)) * loop->position_dt;
            t.log_lateral += log1p(fabs(e2)) * loop->position_dt;
            t.log_heading += log1p(fabs(e3)) * loop->position_dt;
        }
        }
    }
end:
    state[0] = x, state[1] = y, state[2] = heading, state[3] = v, state[4] = omega;
    state[5] = right_angle, state[6] = left_angle;
    *totals = t;
}
