/*
 * How the functions of four_bar.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "four_bar.h"

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
    static const double q[3] = {1.8942348488091483, -1.7844060686319136, 1.7851179758912004};
    static const double qd[3] = {0.6186311741161856, -1.5090139330826062, -0.8319913100426404};
    static const double qdd[3] = {0.30854314588220033, -0.13389748194694207, -0.11143933794994698};
    static const double tau[3] = {1.4098634563031478, -2.3935437356016487, -1.773451708248249};
    int off = 0;
    {
        static const double wanted[24] = {27.8678120521056, -11.159544872075012, 0.0, 0.0, 0.0, -9.652019145361654, 4.033187648851686, 20.06894801815156, 0.0, 0.0, 0.0, 0.0, 38.43915355022321, -3.8787856494878894, 0.0, 0.0, 0.0, -8.552847072295026e-50, -9.129491092854847, -4.106307631135698, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[24] = {1.4e-12, 1.2e-12, 2.2e-308, 2.2e-308, 2.2e-308, 7.8e-12, 8.9e-13, 1.2e-12, 2.2e-308, 2.2e-308, 2.2e-308, 6.7e-12, 1.3e-12, 1.0e-12, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-12, 1.2e-12, 9.8e-13, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        double found[24];
        four_bar_reactions(q, qd, qdd, found);
        off += wrong("reactions", 24, found, wanted, allowed);
    }
    {
        static const double wanted[24] = {-11.792892262046864, 26.22760811830795, 0.0, 0.0, 0.0, 1.4098634563031478, -10.14401072280158, 17.172146389879735, 0.0, 0.0, 0.0, -2.3935437356016487, -5.54687886997325, 40.62927528432761, 0.0, 0.0, 0.0, -1.773451708248249, 3.7027720954224432, -11.03472926397243, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[24] = {2.2e-11, 3.0e-11, 2.2e-308, 2.2e-308, 2.2e-308, 9.0e-11, 1.1e-11, 2.6e-11, 2.2e-308, 2.2e-308, 2.2e-308, 7.6e-11, 1.0e-11, 1.2e-11, 2.2e-308, 2.2e-308, 2.2e-308, 2.5e-11, 6.5e-12, 1.1e-11, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        double found[24];
        four_bar_forward_reactions_ground(q, qd, tau, found);
        off += wrong("forward_reactions_ground", 24, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
