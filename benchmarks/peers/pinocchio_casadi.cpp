// Pinocchio's recursions over CasADi symbols, written as C: the graph that pinocchio.casadi would give.
//
// Reads from stdin: path of the C file, output, n, then the numbers of pinocchio_robot.hpp.
#include <pinocchio/autodiff/casadi.hpp>
#include "pinocchio_robot.hpp"
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <iostream>
#include <vector>

typedef casadi::SX SX;
typedef Eigen::Matrix<SX, Eigen::Dynamic, 1> Vector;

static SX symbols(const std::string &name, int n, Vector &into)
{
    SX all = SX::sym(name, n);
    into.resize(n);
    for (int i = 0; i < n; ++i) into[i] = all(i);
    return all;
}

static SX column(const Vector &from)
{
    SX all(from.size(), 1);
    for (Eigen::Index i = 0; i < from.size(); ++i) all(i) = from[i];
    return all;
}

typedef Eigen::Matrix<SX, Eigen::Dynamic, Eigen::Dynamic> Matrix;

static SX matrix(const Matrix &from, bool symmetric)
{
    SX all(from.rows(), from.cols());
    for (int i = 0; i < from.rows(); ++i)
        for (int j = 0; j < from.cols(); ++j)
            all(i, j) = symmetric ? from(std::min(i, j), std::max(i, j)) : from(i, j);
    return densify(all);
}

// Row by row, as everybody's: CasADi's own order is column by column.
static SX rows(const SX &all) { return densify(all).T(); }

int main()
{
    std::string path;
    int output, n;
    std::cin >> path >> output >> n;
    std::vector<double> numbers(static_cast<size_t>(n * robot::NUMBERS));
    for (double &x : numbers) std::cin >> x;
    auto model = robot::build<SX>(n, numbers.data());
    robot::Data<SX> data(model);
    Vector q, qd, x;
    SX sq = symbols("q", n, q), sqd = symbols("qd", n, qd), sx = symbols("x", n, x), result;
    std::vector<SX> arguments{sq, sqd, sx};
    Matrix by_q = Matrix::Zero(n, n), by_qd = by_q, by_last = by_q;
    switch (output)
    {
    case 0: result = column(pinocchio::rnea(model, data, q, qd, x)); break;
    case 1:
        pinocchio::crba(model, data, q, pinocchio::Convention::LOCAL);
        result = matrix(data.M, true);
        arguments = {sq};
        break;
    case 2: result = column(pinocchio::aba(model, data, q, qd, x, pinocchio::Convention::LOCAL)); break;
    case 3: { // derivatives of inverse dynamics, by CasADi
        const SX tau = column(pinocchio::rnea(model, data, q, qd, x));
        pinocchio::crba(model, data, q, pinocchio::Convention::LOCAL);
        result = rows(horzcat(jacobian(tau, sq), jacobian(tau, sqd), matrix(data.M, true)));
        break;
    }
    case 4: { // the same, by Pinocchio
        pinocchio::computeRNEADerivatives(model, data, q, qd, x, by_q, by_qd, by_last);
        result = rows(horzcat(matrix(by_q, false), matrix(by_qd, false), matrix(by_last, true)));
        break;
    }
    case 5: { // derivatives of forward dynamics, by CasADi
        const SX qdd = column(pinocchio::aba(model, data, q, qd, x, pinocchio::Convention::LOCAL));
        result = rows(horzcat(jacobian(qdd, sq), jacobian(qdd, sqd), jacobian(qdd, sx)));
        break;
    }
    case 6: { // the same, by Pinocchio
        pinocchio::computeABADerivatives(model, data, q, qd, x, by_q, by_qd, by_last);
        result = rows(horzcat(matrix(by_q, false), matrix(by_qd, false), matrix(by_last, false)));
        break;
    }
    default:
        result = column(pinocchio::computeGeneralizedGravity(model, data, q));
        arguments = {sq};
    }
    const casadi::Function f("f", arguments, {cse(densify(result))});
    const size_t slash = path.rfind('/');
    casadi::CodeGenerator code(path.substr(slash + 1));
    code.add(f);
    code.generate(path.substr(0, slash + 1));
    std::cout << f.n_instructions() << std::endl;
    return 0;
}
