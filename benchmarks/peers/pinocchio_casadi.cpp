// Pinocchio's recursions over CasADi symbols, written as C: the graph that pinocchio.casadi would give.
//
// Reads from stdin: path of the C file, output, n, then the numbers of pinocchio_robot.hpp.
#include <pinocchio/autodiff/casadi.hpp>
#include "pinocchio_robot.hpp"
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
    switch (output)
    {
    case 0: result = column(pinocchio::rnea(model, data, q, qd, x)); break;
    case 1:
        pinocchio::crba(model, data, q, pinocchio::Convention::LOCAL);
        result = SX(n, n);
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) result(i, j) = data.M(std::min(i, j), std::max(i, j));
        result = densify(result);
        arguments = {sq};
        break;
    case 2: result = column(pinocchio::aba(model, data, q, qd, x, pinocchio::Convention::LOCAL)); break;
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
