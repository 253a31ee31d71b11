// Pinocchio's recursions in a timing loop of their own, without any copy of the results while the clock runs.
#include "pinocchio_robot.hpp"
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <time.h>

namespace
{
struct Robot
{
    robot::Model<double> model;
    robot::Data<double> data;
    Eigen::MatrixXd by_q, by_qd, by_last; // which the derivatives fill
    explicit Robot(const robot::Model<double> &m)
        : model(m), data(m), by_q(Eigen::MatrixXd::Zero(m.nv, m.nv)), by_qd(by_q), by_last(by_q)
    {
    }
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
    case 5: pinocchio::computeRNEADerivatives(r.model, r.data, q, qd, x, r.by_q, r.by_qd, r.by_last); break;
    case 6: pinocchio::computeABADerivatives(r.model, r.data, q, qd, x, r.by_q, r.by_qd, r.by_last); break;
    case 7: pinocchio::computeJointTorqueRegressor(r.model, r.data, q, qd, x); break;
    case 8: pinocchio::computeCoriolisMatrix(r.model, r.data, q, qd); break;
    default: pinocchio::computeGeneralizedGravity(r.model, r.data, q);
    }
}

int size_of(int output, int n)
{
    return output == 1 || output == 8 ? n * n : output == 7 ? 10 * n * n : output >= 5 ? 3 * n * n : n;
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
    case 5:
    case 6: {
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> all(out, n, 3 * n);
        all << r.by_q, r.by_qd, r.by_last;
        if (output == 5) all.rightCols(n) = Eigen::MatrixXd(r.by_last.selfadjointView<Eigen::Upper>());
        break;
    }
    case 7:
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(out, n, 10 * n) =
            r.data.jointTorqueRegressor;
        break;
    case 8:
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(out, n, n) = r.data.C;
        break;
    default: Eigen::Map<Eigen::VectorXd>(out, n) = r.data.g;
    }
}
} // namespace

extern "C" void *peer_robot(int n, const double *numbers) { return new Robot(robot::build<double>(n, numbers)); }

// Seconds for `sweeps` passes over the states, (states, nq) and (states, nv); results are copied to `out` unless it is null.
extern "C" double peer_time(void *handle, int output, long states, long sweeps, const double *q, const double *qd,
                            const double *x, double *out)
{
    Robot &r = *static_cast<Robot *>(handle);
    const int nq = r.model.nq, n = r.model.nv, size = size_of(output, n);
    timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long sweep = 0; sweep < sweeps; ++sweep)
        for (long k = 0; k < states; ++k)
        {
            call(r, output, In(q + k * nq, nq), In(qd + k * n, n), In(x + k * n, n));
            if (out) copy(r, output, out + k * size);
        }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return double(end.tv_sec - start.tv_sec) + 1e-9 * double(end.tv_nsec - start.tv_nsec);
}
