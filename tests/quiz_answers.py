"""Right and wrong answers to questions of five examples, in letters that every learning platform reads."""

from __future__ import annotations

PENDULUM = [
    ("square:1", "(l*q1_dot)^2", True),
    ("square:1", "l^2*q1_dot", False),
    ("potential:1", "-m*g*l*cos(q1)", True),
    ("potential:1", "m*g*l*(1 - cos(q1))", True),
    ("potential:1", "m*g*l*cos(q1)", False),
    ("momentum:1", "2*m*l^2*q1_dot/2", True),
    ("momentum:1", "m*l*q1_dot", False),
    ("rate:1", "m*l^2*q1_ddot", True),
    ("rate:1", "tau1 - b*q1_dot - m*g*l*sin(q1)", True),
    ("slope:1", "-9.81*m*l*sin(q1)", True),
    ("slope:1", "m*g*l*sin(q1)", False),
    ("equation:1", "m*l^2*q1_ddot + m*g*l*sin(q1)", True),
    ("equation:1", "2*m*l^2*q1_ddot + 2*m*g*l*sin(q1) - tau1 + b*q1_dot", True),
    ("equation:1", "m*l^2*q1_ddot - m*g*l*sin(q1)", False),
    ("equation:1", "tau1 - b*q1_dot", False),
    ("equation:1", "0", False),
    ("coefficients:k_G", "m*g*l*sin(q1)", True),
    ("coefficients:k_G", "m*g*l*cos(q1)", False),
    ("physics:frequency", "sqrt(g/l)", True),
    ("physics:frequency", "4.43", True),
    ("physics:frequency", "4.6", False),
    ("physics:frequency", "sqrt(l/g)", False),
]

TWO_LINK = [
    ("square:2", "h1^2*q1_dot^2 + h2^2*(q1_dot + q2_dot)^2 + 2*h1*h2*q1_dot*(q1_dot + q2_dot)*cos(q2)", True),
    ("square:2", "h1^2*q1_dot^2 + h2^2*q2_dot^2 + 2*h1*h2*q1_dot*q2_dot*cos(q2)", False),
    ("potential:2", "-m2*g*(h1*cos(q1) + h2*cos(q1)*cos(q2) - h2*sin(q1)*sin(q2))", True),
    ("potential:2", "-m2*g*(h1*cos(q1) + h2*cos(q2))", False),
    ("coefficients:k_z:k_z:1,1", "(m1 + m2)*h1^2 + m2*h2^2 + 2*m2*h1*h2*cos(q2)", True),
    ("coefficients:k_z:k_z:1,1", "(m1 + m2)*h1^2 + m2*h2^2 + m2*h1*h2*cos(q2)", False),
    ("coefficients:k_z:k_z:1,2", "m2*h2*(h2 + h1*cos(q2))", True),
    ("coefficients:k_D:k_D:2,1", "-m2*h1*h2*sin(q2)", False),
    ("equation:2", "m2*h2*(h2 + h1*cos(q2))*q1_ddot + m2*h2^2*q2_ddot + m2*h1*h2*q1_dot^2*sin(q2) "
                   "+ m2*g*h2*sin(q1 + q2)", True),
    ("equation:2", "m2*h2*(h2 + h1*cos(q2))*q1_ddot + m2*h2^2*q2_ddot + m2*g*h2*sin(q1 + q2)", False),
    ("equation:2", "m2*h2*(h2 + h1*cos(q2))*q1_ddot + m2*h2^2*q2_ddot + m2*h1*h2*q1_dot^2*sin(q2) "
                   "- m2*g*h2*sin(q1 + q2)", False),
    ("equation:2", "M2", False),
]  # fmt: skip

CART_POLE = [
    ("square:2", "x_dot^2 - l*x_dot*theta_dot*cos(theta) + l^2*theta_dot^2/4", True),
    ("square:2", "x_dot^2 + l*x_dot*theta_dot*cos(theta) + l^2*theta_dot^2/4", False),
    ("potential:2", "mp*g*l/2*cos(theta)", True),
    ("potential:2", "mp*g*l/2*cos(theta) + mc*g*l", True),
    ("potential:2", "mp*g*l*cos(theta)", False),
    ("equation:1", "(mc + mp)*x_ddot - mp*l/2*(theta_ddot*cos(theta) - theta_dot^2*sin(theta))", True),
    ("equation:1", "(mc + mp)*x_ddot - mp*l/2*theta_ddot*cos(theta)", False),
    ("equation:2", "mp*l^2/3*theta_ddot - mp*l/2*x_ddot*cos(theta) - mp*g*l/2*sin(theta)", True),
    ("equation:2", "2*l*theta_ddot - 3*x_ddot*cos(theta) - 3*g*sin(theta)", True),
    ("equation:2", "mp*l^2/4*theta_ddot - mp*l/2*x_ddot*cos(theta) - mp*g*l/2*sin(theta)", False),
    ("equation:2", "mp*l^2/3*theta_ddot - mp*l/2*cos(theta)*((F - b*x_dot + mp*l/2*(theta_ddot*cos(theta) "
                   "- theta_dot^2*sin(theta)))/(mc + mp)) - mp*g*l/2*sin(theta)", True),
    ("equation:2", "(mc + mp)*x_ddot - mp*l/2*(theta_ddot*cos(theta) - theta_dot^2*sin(theta)) - F + b*x_dot", False),
    ("coefficients:k_z:k_z:2,2", "mp*l^2/3", True),
    ("coefficients:k_z:k_z:2,2", "mp*l^2/12", False),
]  # fmt: skip

FOUR_BAR = [
    ("square:1", "a^2*phi_dot^2/4", True),
    ("square:1", "a^2*phi_dot^2", False),
    ("potential:3", "m3*g*c*sin(chi)/2", True),
    ("potential:3", "m3*g/2*(a*sin(phi) + b*sin(phi + psi))", True),
    ("potential:3", "m3*g*c*sin(chi)", False),
    ("momentum:3", "m3*c^2*chi_dot/3", True),
    ("momentum:3", "m3*c*(a*phi_dot*cos(phi - chi) + b*(phi_dot + psi_dot)*cos(phi + psi - chi))/3", True),
    ("momentum:3", "m3*c^2*chi_dot/12", False),
    ("equation:3", "m3*c^2*chi_ddot/3 + m3*g*c*cos(chi)/2", True),
    ("equation:3", "m3*c^2*chi_ddot/3 - m3*g*c*cos(chi)/2", False),
    ("coefficients:k_z:k_z:3,3", "m3*c^2/3", True),
    ("coefficients:k_z:k_z:3,3", "m3*c^2/4", False),
]

WHEEL = [
    ("square:2", "x_dot^2", True),
    ("square:2", "r^2*phi_dot^2", True),
    ("square:2", "r*phi_dot^2", False),
    ("momentum:1", "(M + m)*x_dot", True),
    ("momentum:1", "(M + m)*r*phi_dot", True),
    ("momentum:1", "M*x_dot", False),
    ("equation:1", "(M + m)*x_ddot", True),
    ("equation:1", "(M + m)*r*phi_ddot", True),
    ("equation:1", "M*x_ddot", False),
    ("equation:2", "m*r^2*phi_ddot/2", True),
    ("equation:2", "m*r*x_ddot/2", True),
    ("equation:2", "m*r^2*phi_ddot", False),
]

ANSWERS = {"pendulum": PENDULUM, "two_link": TWO_LINK, "cart_pole": CART_POLE, "four_bar": FOUR_BAR,
           "cart_with_wheel": WHEEL}  # fmt: skip
"""By example the key of a question, an answer, and whether it is right."""
