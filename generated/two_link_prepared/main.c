/*
 * How the functions of two_link.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "two_link.h"

#include <math.h>
#include <stdio.h>

/* Print whether `count` numbers are what they must be, and return how many are not; what is no number never is. */
static int wrong(const char *name, int count, const double *found, const double *wanted, const double *allowed)
{
    int off = 0;
    for (int k = 0; k < count; k++) {
        if (!(fabs(found[k] - wanted[k]) <= allowed[k])) {
            off++;
        }
    }
    printf("%-40s %s (%d of %d numbers)\n", name, off ? "WRONG" : "right", count - off, count);
    return off;
}

int main(void)
{
    static const double params[5] = {1.315705808134858, 0.7025989885613477, 1.2975196626485332, 1.1546577935290463, 0.6227465167293484};
    static const double q[2] = {-1.2479869650639606, 0.4628147188233003};
    static const double qd[2] = {-0.13389748194694207, -0.11143933794994698};
    static const double qdd[2] = {0.563945382521259, -0.9574174942406595};
    double prepared[10];
    static const double tau[2] = {-3.502219465614872, 3.5162090914730353};
    int off = 0;
    {
        static const double wanted[10] = {1.2975196626485332, 1.1546577935290463, 0.6227465167293484, 2.6187901589311773, 0.8112613978679855, 1.052627615281446, 2.5950393252970665, 0.9367292956375378, 0.45581800130766026, 3.1517953806295296};
        static const double allowed[10] = {1.5e-16, 1.3e-16, 7.3e-17, 1.5e-15, 2.8e-16, 6.1e-16, 1.5e-15, 5.5e-16, 3.7e-16, 2.6e-15};
        two_link_prepare(params, prepared);
        off += wrong("prepare", 10, prepared, wanted, allowed);
    }
    {
        static const double wanted[2] = {-0.2153862063017747, -0.1861331109160852};
        static const double allowed[2] = {7.5e-15, 2.0e-15};
        double found[2];
        two_link_inverse_dynamics(q, qd, qdd, prepared, found);
        off += wrong("inverse_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {-3.806746493610227, 11.760462272571639};
        static const double allowed[2] = {6.0e-14, 1.5e-13};
        double found[2];
        two_link_forward_dynamics(q, qd, tau, prepared, found);
        off += wrong("forward_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {6.218442053267713, 1.8786198126707856, 1.8786198126707856, 0.9367292956375378};
        static const double allowed[4] = {1.2e-14, 3.5e-15, 3.5e-15, 5.5e-16};
        double found[4];
        two_link_mass_matrix(q, prepared, found);
        off += wrong("mass_matrix", 4, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
