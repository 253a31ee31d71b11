// Pinocchio's constrained dynamics and their derivatives: points of a robot's bodies held to places of the ground.
#include "pinocchio_robot.hpp"
#include <pinocchio/algorithm/constrained-dynamics-derivatives.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <time.h>

namespace
{
typedef pinocchio::RigidConstraintModelTpl<double, 0> Holding;
typedef pinocchio::RigidConstraintDataTpl<double, 0> HoldingData;

struct Robot
{
    robot::Model<double> model;
    robot::Data<double> data;
    PINOCCHIO_STD_VECTOR_WITH_EIGEN_ALLOCATOR(Holding) held;
    PINOCCHIO_STD_VECTOR_WITH_EIGEN_ALLOCATOR(HoldingData) held_data;
    explicit Robot(const robot::Model<double> &m) : model(m), data(m) {}
};

typedef Eigen::Map<const Eigen::VectorXd> In;

void call(Robot &r, bool derivatives, In q, In qd, In tau)
{
    pinocchio::ProximalSettings settings(1e-12, 0., 1);
    pinocchio::constraintDynamics(r.model, r.data, q, qd, tau, r.held, r.held_data, settings);
    if (!derivatives) return;
    pinocchio::computeConstraintDynamicsDerivatives(r.model, r.data, r.held, r.held_data, settings);
}
} // namespace

// holdings: for each point its joint (from 1) and where it is on that joint's body (3).
extern "C" void *peer_robot(int n, const double *numbers, int points, const double *holdings)
{
    Robot *r = new Robot(robot::build<double>(n, numbers));
    for (int k = 0; k < points; ++k)
    {
        const double *at = holdings + 4 * k;
        const pinocchio::SE3 place(Eigen::Matrix3d::Identity(), Eigen::Vector3d(at[1], at[2], at[3]));
        r->held.push_back(Holding(
            pinocchio::CONTACT_3D, r->model, static_cast<pinocchio::JointIndex>(at[0]), place,
            pinocchio::LOCAL_WORLD_ALIGNED));
        r->held_data.push_back(HoldingData(r->held.back()));
    }
    pinocchio::initConstraintDynamics(r->model, r->data, r->held, r->held_data);
    return r;
}

// Seconds for `sweeps` passes over the states; unless `out` is null, accelerations and forces are copied to it, or
// accelerations [by q | by qd | by tau], and then forces if `size` leaves room for them.
extern "C" double peer_time(void *handle, int derivatives, long size, long states, long sweeps, const double *q, const double *qd,
                            const double *tau, double *out)
{
    Robot &r = *static_cast<Robot *>(handle);
    const int nq = r.model.nq, n = r.model.nv;
    timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long sweep = 0; sweep < sweeps; ++sweep)
        for (long k = 0; k < states; ++k)
        {
            call(r, derivatives, In(q + k * nq, nq), In(qd + k * n, n), In(tau + k * n, n));
            if (!out) continue;
            const long m = r.data.lambda_c.size();
            if (!derivatives) {
                Eigen::Map<Eigen::VectorXd> all(out + k * size, n + m);
                all << r.data.ddq, r.data.lambda_c;
                continue;
            }
            typedef Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> Rows;
            Rows(out + k * size, n, 3 * n) << r.data.ddq_dq, r.data.ddq_dv, r.data.ddq_dtau;
            if (m && size > 3 * n * n)
                Rows(out + k * size + 3 * n * n, m, 3 * n) << r.data.dlambda_dq, r.data.dlambda_dv, r.data.dlambda_dtau;
        }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return double(end.tv_sec - start.tv_sec) + 1e-9 * double(end.tv_nsec - start.tv_nsec);
}
