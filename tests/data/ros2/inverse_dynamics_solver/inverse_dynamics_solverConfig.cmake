set(inverse_dynamics_solver_INCLUDE_DIRS "${CMAKE_CURRENT_LIST_DIR}/../include")
