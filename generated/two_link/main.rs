// How the functions of two_link.rs are called: every one of them once, at one state, with what must come out beside it.
//
//     rustc --edition 2021 -O main.rs && ./main
//
// The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
// prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.

#[path = "two_link.rs"]
mod scene;

/// Prints whether numbers are what they must be, and returns how many are not; what is no number never is.
fn wrong<const N: usize>(name: &str, found: &[f64; N], wanted: &[f64; N], allowed: &[f64; N]) -> usize {
    let right = (0..N).filter(|&k| (found[k] - wanted[k]).abs() <= allowed[k]).count();
    println!("{:40} {} ({} of {} numbers)", name, if right < N { "WRONG" } else { "right" }, right, N);
    N - right
}

fn main() {
    let q: [f64; 2] = [1.8942348488091483, -1.7844060686319136];
    let qd: [f64; 2] = [1.1900786505941334, 0.6186311741161856];
    let qdd: [f64; 2] = [-1.5090139330826062, -0.8319913100426404];
    let params: [f64; 5] = [1.0771357864705502, 0.9665256295132645, 0.9721401655125133, 1.1409863456303149, 0.7606456264398351];
    let tau: [f64; 2] = [-1.773451708248249, 4.433856233091829];
    let mut off = 0;
    let mut found = [0.0; 2];
    scene::inverse_dynamics(&q, &qd, &qdd, &params, &mut found);
    let wanted = [-1.5166918093194068, -3.994576113466394];
    let allowed = [2.9e-14, 9.8e-15];
    off += wrong("inverse_dynamics", &found, &wanted, &allowed);
    let mut found = [0.0; 2];
    scene::forward_dynamics(&q, &qd, &tau, &params, &mut found);
    let wanted = [-5.2982331392697875, 8.971248111859595];
    let allowed = [4.5e-14, 5.9e-14];
    off += wrong("forward_dynamics", &found, &wanted, &allowed);
    let mut found = [0.0; 4];
    scene::mass_matrix(&q, &params, &mut found);
    let wanted = [2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194];
    let allowed = [4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16];
    off += wrong("mass_matrix", &found, &wanted, &allowed);
    let mut found = [0.0; 2];
    scene::velocity_forces(&q, &qd, &params, &mut found);
    let wanted = [1.9436399856191295, -1.4838483535569849];
    let allowed = [1.7e-14, 4.7e-15];
    off += wrong("velocity_forces", &found, &wanted, &allowed);
    let mut found = [0.0; 2];
    scene::gravity_forces(&q, &params, &mut found);
    let wanted = [1.5247788152016606, 0.09194304874029749];
    let allowed = [6.4e-15, 1.9e-15];
    off += wrong("gravity_forces", &found, &wanted, &allowed);
    let mut found = [0.0; 4];
    scene::coriolis_matrix(&q, &qd, &params, &mut found);
    let wanted = [0.6481417417818378, 1.8949907234152703, -1.2468489816334325, 0.0];
    let allowed = [1.9e-15, 6.0e-15, 3.6e-15, 2.2e-308];
    off += wrong("coriolis_matrix", &found, &wanted, &allowed);
    let mut found = [0.0; 2];
    scene::momentum(&q, &qd, &params, &mut found);
    let wanted = [3.8928112723558224, 2.005382192320685];
    let allowed = [9.1e-15, 3.6e-15];
    off += wrong("momentum", &found, &wanted, &allowed);
    let found = [scene::kinetic_energy(&q, &qd, &params)];
    let wanted = [2.936671763104942];
    let allowed = [9.3e-15];
    off += wrong("kinetic_energy", &found, &wanted, &allowed);
    let found = [scene::potential_energy(&q, &params)];
    let wanted = [-0.35347950003900824];
    let allowed = [5.0e-15];
    off += wrong("potential_energy", &found, &wanted, &allowed);
    let mut found = [0.0; 4];
    scene::k_z(&q, &params, &mut found);
    let wanted = [2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194];
    let allowed = [4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16];
    off += wrong("k_z", &found, &wanted, &allowed);
    let mut found = [0.0; 2];
    scene::k_C(&q, &params, &mut found);
    let wanted = [2.095406015410758, 0.0];
    let allowed = [6.6e-15, 2.2e-308];
    off += wrong("k_C", &found, &wanted, &allowed);
    let mut found = [0.0; 4];
    scene::k_D(&q, &params, &mut found);
    let wanted = [0.0, 1.047703007705379, -1.047703007705379, 0.0];
    let allowed = [2.2e-308, 2.8e-15, 2.8e-15, 2.2e-308];
    off += wrong("k_D", &found, &wanted, &allowed);
    let mut found = [0.0; 2];
    scene::k_G(&q, &params, &mut found);
    let wanted = [1.5247788152016606, 0.09194304874029749];
    let allowed = [6.4e-15, 1.9e-15];
    off += wrong("k_G", &found, &wanted, &allowed);
    let mut found = [0.0; 12];
    scene::pose_tool(&q, &params, &mut found);
    let wanted = [0.9939748796082962, -0.10960811424193481, 0.0, 1.0467942753507573, 0.10960811424193481, 0.9939748796082962, 0.0, -0.8251377579962568, 0.0, 0.0, 1.0, 0.0];
    let allowed = [4.3e-15, 2.1e-15, 2.2e-308, 4.7e-15, 2.1e-15, 4.3e-15, 2.2e-308, 6.0e-15, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308];
    off += wrong("pose_tool", &found, &wanted, &allowed);
    let mut found = [0.0; 12];
    scene::jacobian_tool(&q, &params, &mut found);
    let wanted = [0.8251377579962568, 1.134111765532602, 1.0467942753507573, 0.12506136172033527, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0];
    let allowed = [6.0e-15, 6.9e-15, 4.7e-15, 6.5e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16, 3.5e-16];
    off += wrong("jacobian_tool", &found, &wanted, &allowed);
    let mut found = [0.0; 6];
    scene::jdot_qdot_tool(&q, &qd, &params, &mut found);
    let wanted = [-1.7145681668147574, 3.272572717739957, 0.0, 0.0, 0.0, 0.0];
    let allowed = [1.8e-14, 2.4e-14, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308];
    off += wrong("jdot_qdot_tool", &found, &wanted, &allowed);
    std::process::exit((off > 0) as i32);
}
