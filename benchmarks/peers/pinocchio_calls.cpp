// Pinocchio's recursions in a timing loop of their own, without any copy of the results while the clock runs.
#include "pinocchio_robot.hpp"
#include <time.h>

namespace
{
struct Robot
{
    robot::Model<double> model;
    robot::Data<double> data;
    explicit Robot(const robot::Model<double> &m) : model(m), data(m) {}
};

typedef Eigen::Map<const Eigen::VectorXd> In;

void call(Robot &r, int output, In q, In qd, In x)
{
    switch (output)
    {
    case 0: pinocchio::rnea(r.model, r.data, q, qd, x); break;
    case 1: pinocchio::crba(r.model, r.data, q, pinocchio::Convention::LOCAL); break;
    case 2: pinocchio::aba(r.model, r.data, q, qd, x, pinocchio::Convention::LOCAL); break;
    case 3: pinocchio::aba(r.model, r.data, q, qd, x, pinocchio::Convention::WORLD); break;
    default: pinocchio::computeGeneralizedGravity(r.model, r.data, q);
    }
}

void copy(const Robot &r, int output, double *out)
{
    const int n = r.model.nv;
    switch (output)
    {
    case 0: Eigen::Map<Eigen::VectorXd>(out, n) = r.data.tau; break;
    case 1: Eigen::Map<Eigen::MatrixXd>(out, n, n) = r.data.M.selfadjointView<Eigen::Upper>(); break;
    case 2:
    case 3: Eigen::Map<Eigen::VectorXd>(out, n) = r.data.ddq; break;
    default: Eigen::Map<Eigen::VectorXd>(out, n) = r.data.g;
    }
}
} // namespace

extern "C" void *peer_robot(int n, const double *numbers) { return new Robot(robot::build<double>(n, numbers)); }

// Seconds for `sweeps` passes over the states, (states, n) each; results are copied to `out` unless it is null.
extern "C" double peer_time(void *handle, int output, long states, long sweeps, const double *q, const double *qd,
                            const double *x, double *out)
{
    Robot &r = *static_cast<Robot *>(handle);
    const int n = r.model.nv, size = output == 1 ? n * n : n;
    timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long sweep = 0; sweep < sweeps; ++sweep)
        for (long k = 0; k < states; ++k)
        {
            call(r, output, In(q + k * n, n), In(qd + k * n, n), In(x + k * n, n));
            if (out) copy(r, output, out + k * size);
        }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return double(end.tv_sec - start.tv_sec) + 1e-9 * double(end.tv_nsec - start.tv_nsec);
}
