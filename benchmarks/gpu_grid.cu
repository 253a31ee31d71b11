/* Times of the kernels that GRiD generates, a line each, "name states seconds", and what comes out at known states.
 *
 * grid.cuh is its header. It runs one state a block, and says itself that threads of a block change nothing but the time:
 * of those tried the fastest stands, and of its two ways to accelerations the faster one. */
#include "grid.cuh"
#include "gpu_clock.cuh"

const size_t AXES = grid::NUM_JOINTS;
const int THREADS[] = {32, 64, 96, 128, 192, 256};
const REAL GRAVITY = (REAL)-9.81;

int main()
{
    card();
    grid::init_grid_kernel_attrs<REAL>();
    const grid::robotModel<REAL> *model = grid::init_robotModel<REAL>();
    const double *given = known(AXES);
    const double *q = given, *qd = q + KNOWN * AXES, *qdd = qd + KNOWN * AXES, *tau = qdd + KNOWN * AXES;
    REAL *host = (REAL *)malloc(MOST * 3 * AXES * sizeof(REAL));
    REAL *state, *forced, *faster, *out;
    CHECK(cudaMalloc(&state, MOST * 2 * AXES * sizeof(REAL)));
    CHECK(cudaMalloc(&forced, MOST * 3 * AXES * sizeof(REAL)));
    CHECK(cudaMalloc(&faster, MOST * AXES * sizeof(REAL)));
    CHECK(cudaMalloc(&out, MOST * AXES * sizeof(REAL)));
    const auto put = [&](REAL *to, size_t parts, const double *const *from) {
        for (size_t k = 0; k < MOST; k++) {
            for (size_t i = 0; i < parts * AXES; i++) {
                host[k * parts * AXES + i] = (REAL)from[i / AXES][k % KNOWN * AXES + i % AXES];
            }
        }
        CHECK(cudaMemcpy(to, host, MOST * parts * AXES * sizeof(REAL), cudaMemcpyHostToDevice));
    };
    const double *parts[] = {q, qd, tau};
    put(state, 2, parts);
    put(forced, 3, parts);
    put(faster, 1, &qdd);
    const auto inverse = [&](size_t n, int threads) {
        grid::inverse_dynamics_kernel<REAL><<<n, threads, grid::INVERSE_DYNAMICS_DYNAMIC_SHARED_MEM_BYTES<REAL>()>>>(
            out, state, 2 * AXES, faster, nullptr, model, GRAVITY, n);
    };
    const auto forward = [&](size_t n, int threads) {
        grid::forward_dynamics_kernel<REAL><<<n, threads, grid::FORWARD_DYNAMICS_DYNAMIC_SHARED_MEM_BYTES<REAL>()>>>(
            out, nullptr, forced, 3 * AXES, nullptr, model, GRAVITY, n);
    };
    const auto articulated = [&](size_t n, int threads) {
        grid::aba_kernel<REAL><<<n, threads, grid::ABA_DYNAMIC_SHARED_MEM_BYTES<REAL>()>>>(
            out, nullptr, forced, 3 * AXES, nullptr, model, GRAVITY, n);
    };
    inverse(KNOWN, THREADS[0]);
    tell("inverse_dynamics", out, KNOWN * AXES);
    articulated(KNOWN, THREADS[0]);
    tell("forward_dynamics", out, KNOWN * AXES);
    forward(KNOWN, THREADS[0]);
    tell("forward_dynamics", out, KNOWN * AXES);
    for (size_t n = 16; n <= MOST; n = n == 262144 ? MOST : n * 4) {
        double least[] = {1e9, 1e9};
        for (int threads : THREADS) {
            least[0] = fmin(least[0], seconds([&] { inverse(n, threads); }));
            least[1] = fmin(least[1], seconds([&] { forward(n, threads); }));
            least[1] = fmin(least[1], seconds([&] { articulated(n, threads); }));
        }
        printf("inverse_dynamics %zu %.9g\nforward_dynamics %zu %.9g\n", n, least[0], n, least[1]);
    }
    return 0;
}
