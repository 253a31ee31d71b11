/*
 * How the functions of cart_pole.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "cart_pole.h"

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
    static const double q[2] = {1.8942348488091483, -1.7844060686319136};
    static const double qd[2] = {1.1900786505941334, 0.6186311741161856};
    static const double qdd[2] = {-1.5090139330826062, -0.8319913100426404};
    static const double tau[2] = {0.771357864705501, -0.33474370486735516};
    int off = 0;
    {
        static const double wanted[12] = {-1.67367481205852, 10.772701182012003, 0.0, 0.0, 0.0, 0.22474535344322544, -0.9059146746899238, -0.3650005110871458, 0.0, 0.0, 0.0, 0.22474535344322544};
        static const double allowed[12] = {3.6e-15, 1.2e-14, 2.2e-308, 2.2e-308, 2.2e-308, 8.2e-16, 3.3e-15, 1.2e-15, 2.2e-308, 2.2e-308, 2.2e-308, 8.2e-16};
        double found[12];
        cart_pole_reactions(q, qd, qdd, found);
        off += wrong("reactions", 12, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {0.6523499996460878, 9.094383900450369, 0.0, 0.0, 0.0, -0.33474370486735516, -0.2841668693625382, -0.7156160995496317, 0.0, 0.0, 0.0, -0.33474370486735516};
        static const double allowed[12] = {6.0e-15, 1.5e-14, 2.2e-308, 2.2e-308, 2.2e-308, 2.3e-15, 3.3e-15, 9.3e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.3e-15};
        double found[12];
        cart_pole_forward_reactions_ground(q, qd, tau, found);
        off += wrong("forward_reactions_ground", 12, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
