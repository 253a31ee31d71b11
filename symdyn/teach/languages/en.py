"""English prose of the steps."""

TEXTS = {
    "title": "The equations of motion of {scene}, step by step",
    "section.scene": "The mechanism",
    "section.positions": "Positions",
    "section.velocities": "Velocities",
    "section.energies": "Energies",
    "section.lagrangian": "The Lagrangian",
    "section.equations": "Lagrange's equations",
    "section.coefficients": "The coefficients and what they mean",
    "section.numbers": "In numbers",
    # tables
    "table.joint": "joint",
    "table.kind": "kind",
    "table.parent": "on",
    "table.child": "carries",
    "table.coordinate": "coordinate",
    "table.symbol": "symbol",
    "table.meaning": "meaning",
    "table.unit": "unit",
    "table.value": "value",
    "table.coefficient": "coefficient",
    "table.why": "why",
    "table.where": "where",
    "ground": "ground",
    # the mechanism
    "scene": "{scene} is an open mechanism. Moving bodies: {bodies}; degrees of freedom: {freedoms}.",
    "scene.reason": "Every moving body hangs on one joint, so the coordinates of the joints fix where everything is.",
    "acting": "Beside drives and weights this acts:",
    "acting.force": "a force beside the drive",
    "acting.damping": "viscous damping",
    "acting.motion": "prescribed motion",
    "acting.coupling": "coupling",
    "acting.follows": "joint {joint} follows joint {leader}: its coordinate is {position}",
    "acting.joint": "joint {joint}",
    "acting.reason": "A coordinate whose motion is prescribed follows its formula; its drive is whatever that takes. "
    "The equations hold for any motion; the numbers below are for the state that is listed there.",
    "picture.caption": "{scene}: coordinates, the frames of the joints, the direction of gravity.",
    "notation": "These symbols are used; a dot is a derivative with respect to time.",
    "notation.angle": "angle of joint {joint}",
    "notation.way": "displacement in joint {joint}",
    "notation.rate": "rate of {q}",
    "notation.torque": "driving torque of joint {joint}",
    "notation.force": "driving force of joint {joint}",
    "notation.parameter": "parameter",
    "long": "{name} is long: {terms} terms",
    "long.short": "{terms} terms",
    # positions and velocities
    "position.particle": "The point mass {tag} of {body} is, seen from the ground, at",
    "position.centre": "The centre of mass {tag} of {body} is, seen from the ground, at",
    "position.origin": "The origin of the frame of {body}, index {tag}, is, seen from the ground, at",
    "velocity": "The velocity of place {tag} is the derivative of its position.",
    "velocity.reason": "Product and chain rule: the derivative of a sine is the cosine times the rate of the whole "
    "angle, that of a cosine is minus the sine times that rate, that of a displacement is its rate. Parameters are "
    "constant.",
    "velocity.term": "term",
    "velocity.rate": "its derivative",
    "velocity.terms": "Differentiation, term by term",
    "velocity.rests": "Place {tag} is at rest.",
    "turning": "{body} turns with this angular velocity, written along its own axes.",
    "turning.reason": "The skew matrix of the angular velocity is the transposed rotation matrix times its derivative. "
    "Along the body's own axes the moments of inertia are constant.",
    # energies
    "square": "The square of the speed of place {tag} is the sum of the squares of its components.",
    "square.out": "Multiplied out, with everything but sines and cosines in front of the brackets:",
    "square.fold": "Multiplied out: {terms} terms",
    "square.result": "With that:",
    "square.long": "Multiplied out, it fills pages; below, the kinetic energy has its simplest form.",
    "identity.pythagoras": "Because sin² + cos² = 1:",
    "identity.addition": "By the addition formula cos(a − b) = cos a cos b + sin a sin b and its kin:",
    "kinetic": "The kinetic energy of mass {tag} of {body}.",
    "spin": "The kinetic energy of the rotation of {body}.",
    "spin.reason": "Half of the moments of inertia times the squares of the angular velocities along the body's axes, "
    "and the products of inertia times two of them.",
    "offset": "The body frame's origin is not the centre of mass of {body}: a mixed term joins both motions.",
    "offset.reason": "It is the velocity of the origin times the angular velocity crossed with the first moment.",
    "rotor": "The rotor of joint {joint} turns too.",
    "potential": "The potential energy of mass {tag} of {body} in the field of gravity.",
    "potential.reason": "The work of the weight on the way from here to the origin: minus the scalar product of the "
    "weight and the position vector, that is weight times height.",
    "springs": "The springs store energy.",
    "springs.reason": "The energy is the force added up along the way from the free length.",
    "energies": "Together: the kinetic and the potential energy.",
    "lagrangian": "The Lagrangian is kinetic minus potential energy.",
    # equations
    "momentum": "First {slope}.",
    "momentum.reason": "In the kinetic energy only terms with {rate} count: a square gives twice its coefficient times "
    "{rate}, a product gives the other rate. The potential energy has no rates.",
    "rate": "Its derivative with respect to time, {rate}.",
    "rate.reason": "Product and chain rule: each term gives one with the acceleration in place of the rate, and one "
    "for every coordinate that its coefficient depends on, times that coordinate's rate.",
    "rate.term": "term",
    "rate.from": "through",
    "rate.gives": "gives",
    "rate.fold": "Which term comes from which rate",
    "slope": "Then {slope}.",
    "slope.reason": "Rates are held fixed; what depends on {q} is differentiated.",
    "slope.absent": "The kinetic energy does not depend on {q}; only the potential energy may.",
    "equation": "Lagrange's equation {left} = {right}, sorted by accelerations and rates, is",
    "equation.reason": "The drive of {q} has to supply this.",
    "equation.passive": "Nothing drives {q}; so the sum of these terms equals what else acts there.",
    "equation.named": "Coefficients that are long appear by name; they are written out below.",
    # coefficients
    "coefficients.k_z": "What multiplies the accelerations:",
    "coefficients.k_C": "What multiplies products of two rates:",
    "coefficients.k_D": "What multiplies squares of rates:",
    "coefficients.k_G": "What gravity contributes:",
    "coefficients.k_E": "What springs contribute:",
    "coefficients.zero": "Identically zero: {names}.",
    "check.title": "Check",
    "check.equal": "{first} − {second} = 0 for all positions and parameters: both were derived, and their difference "
    "has no term left.",
    "inertia": "{name} is the moment of inertia about the axis of joint {joint} of everything beyond it: {tags}.",
    "inertia.reason": "If the other joints are locked, everything beyond the axis is one rigid body that turns about "
    "it. Its moment of inertia is found here from distances alone, without any energy.",
    "inertia.torque": "The acceleration {rate} alone asks for",
    "mass": "{name} is the mass that joint {joint} moves: {tags}.",
    "mass.reason": "If the other joints are locked, everything beyond the slide is one rigid body that is shifted.",
    "induced": "{name} is what {rate} induces in the axis of joint {joint}, whose own drive has to hold it.",
    "induced.how": "At rest, with {rate} = 1, each mass resists with minus mass times acceleration. The moments of "
    "these forces about the first axis (along it, for a slide) add up to minus",
    "induced.split": "Their moment about the first axis is that about the second, and that of their resultant placed "
    "on the second axis:",
    "induced.twin": "and both are one function:",
    "induced.reason": "The kinetic energy holds one term with the product of both rates. Differentiated by one rate "
    "and then by the other, in either order, it gives the same coefficient.",
    "induced.none": "{name} is zero: the forces with which the masses resist {rate} have no moment about the axis of "
    "joint {joint}.",
    "induced.none.slide": "{name} is zero: the forces with which the masses resist {rate} have no component along "
    "joint {joint}.",
    "meaning.k_D": "Squares of rates: centripetal acceleration and the force that it takes.",
    "meaning.k_D.reason": "A mass on a circle is accelerated towards the axis. The centrifugal force that answers has "
    "a moment about another axis only if its line neither meets that axis nor is parallel to it, and a component "
    "along a slide only if it is not at right angles to it.",
    "meaning.k_C": "Products of two different rates: Coriolis acceleration.",
    "meaning.k_C.reason": "What moves relative to a body that turns is accelerated by twice the angular velocity "
    "crossed with the relative velocity.",
    "meaning.others": "Joints with several freedoms, or that others follow: {joints}. Their coefficients are not "
    "derived a second time here.",
    "k_D.acts": "{j} presses the masses away from axis {axis}; this force has a moment about axis {i}",
    "k_D.acts.slide": "{j} presses the masses away from axis {axis}; this force has a component along slide {i}",
    "k_D.own": "the line of the centrifugal force meets axis {i} itself",
    "k_D.apart": "{j} moves nothing that joint {i} carries",
    "k_D.none": "the masses that {j} turns lie on axis {axis}: there is no centrifugal force",
    "k_D.straight": "a slide is straight: {j} alone causes no centripetal acceleration",
    "k_D.meets": "the centrifugal force of {j} has no moment about axis {i}: its line meets the axis or is parallel "
    "to it",
    "k_D.meets.slide": "the centrifugal force of {j} is at right angles to slide {i}",
    "k_D.cancel": "the moments about axis {i} of the centrifugal forces of {j} cancel",
    "k_D.cancel.slide": "the components along slide {i} of the centrifugal forces of {j} cancel",
    "k_C.acts": "{j} carries what moves with {k}: the Coriolis force has a moment about axis {i}",
    "k_C.acts.slide": "{j} carries what moves with {k}: the Coriolis force has a component along slide {i}",
    "k_C.straight": "a slide does not turn what it carries: {j} and {k} together cause no Coriolis acceleration",
    "k_C.apart": "{j} and {k} together move nothing that joint {i} carries",
    "k_C.none": "{j} and {k} together give no mass a Coriolis acceleration",
    "k_C.meets": "the Coriolis force has no moment about axis {i}: its line meets the axis or is parallel to it",
    "k_C.meets.slide": "the Coriolis force is at right angles to slide {i}",
    "k_C.cancel": "the moments of the Coriolis forces about axis {i} add up to zero",
    "k_C.cancel.slide": "the components of the Coriolis forces along slide {i} add up to zero",
    "weights": "{name} is the torque that holds joint {joint} at rest against the weights.",
    "weights.slide": "{name} is the force that holds joint {joint} at rest against the weights.",
    "weights.reason": "The moments of the weights beyond axis {drive}, added up without any energy, with the opposite "
    "sign.",
    "weights.slide.reason": "The components of the weights beyond slide {drive} along it, added up without any "
    "energy, with the opposite sign.",
    "weights.caption": "The weights, each at its centre of mass.",
    # numbers
    "state": "Chosen: one state, and values of the parameters.",
    "state.reason": "Parameters without a value in the scene are given one here, no two alike.",
    "state.reason.closed": "The loops allow these rates and accelerations; parameters without a value in the scene "
    "are given one.",
    "values": "The coefficients at that position:",
    "torque": "In all, {total} {value}.",
    "torque.passive": "The terms of the equation of {q} add up to {total} {value}. Nothing drives {q}: this is what "
    "the chosen motion would need there, and zero for the motion that the mechanism makes by itself.",
    "shares": "What adds up to {total}: each bar is one product, its length the share in the sum of the amounts.",
    "equilibria": "Where the mechanism rests without drives.",
    "equilibria.reason": "At rest only gravity, springs and constant forces act; they cancel where their potential "
    "energy is level. It is stable where that energy is least. What is exact holds for all values of the parameters.",
    "equilibria.newton": "Beyond what is exact, Newton's method looked from {starts} starts, for the values above; it "
    "may have missed some.",
    "equilibria.turn": "Beyond what is exact, sign changes of the forces were looked for over a whole turn, in steps "
    "of half a degree, for the values above.",
    "equilibria.turns": "Beyond what is exact, sign changes of the forces were looked for from {q} = {least} to "
    "{most}, in steps of half a degree, for the values above; outside there may be others.",
    "equilibria.singular": "No equilibria, though the generalized forces vanish there: {places}. The coordinates are "
    "singular there: they cannot tell every motion that the bodies can make, and on the one that they cannot tell the "
    "forces do work, as the virtual work of all bodies shows.",
    "equilibria.driven": "A motion is prescribed here, or a force depends on time: the mechanism is driven, and no "
    "equilibria are listed.",
    "equilibria.all": "Every position is an equilibrium: no force depends on the position.",
    "equilibria.never": "There is none: what acts at rest depends on no position and is not zero.",
    "equilibria.none": "None was found.",
    "equilibria.idle": "These coordinates do not matter: {names}.",
    "equilibria.kind": "kind",
    "equilibria.how": "found",
    "equilibria.stable": "stable",
    "equilibria.unstable": "unstable",
    "equilibria.undecided": "not decided by second derivatives",
    "equilibria.exact": "exactly",
    "equilibria.numeric": "numerically",
    "power": "Check by energy: what the drives and the other forces put in is the rate of the mechanical energy.",
    "power.reason": "Multiply each equation by its rate and add: the sum is the derivative of kinetic plus potential "
    "energy.",
    "power.numbers": "At the chosen state {left} {value} W, and the right-hand side is ({parts}) W.",
    # textbook
    "textbook.signs.title": "Signs",
    "textbook.signs": "Here each coefficient carries its own sign. The book writes the minus of the Coriolis and "
    "centrifugal terms in front, and so gives these coefficients with the opposite sign.",
    "erratum": "The text of ({number}) is wrong",
    "erratum.several": "The text of ({number}) is wrong",
    "erratum.reads": "As transcribed, in the signs used here: {left} = {form}.",
    "erratum.right": "Right is:",
    "erratum.check": "Check at the state of the last section: the text gives {wrong}; computed from the energies "
    "without the text, {left} {right}.",
    "erratum.5.33": "The sign: y counts upwards, and potential energy grows with height. (5.34) is right.",
    "erratum.5.37": "The third term has the rate of the second joint in place of that of the first. (5.38) is right.",
    "erratum.5.40z": "The coefficient of the second acceleration is named like that of the second equation, and holds "
    "the first mass in place of the second. (5.51) is right.",
    "erratum.5.40D": "The coefficient of the square of the second rate has the cosine in place of the sine. "
    "(5.38) is right.",
    "erratum.5.41": "A momentum has rates, no accelerations and no squares of them.",
    "erratum.5.42": "The derivative of a rate is an acceleration, not a square of the rate.",
    "erratum.5.43": "The square of the first rate is missing, and a mass has no index (read as the second mass in the "
    "check).",
    "erratum.5.44C": "The second equation has no Coriolis term: what the derivative of the momentum gives and what the "
    "slope of the kinetic energy gives cancel.",
    "erratum.5.44D": "The sign of the centrifugal term: spinning about the first axis, the second link is thrown "
    "outwards, and its drive has to hold it back.",
    "erratum.axes": "The axes of the joints are printed like angular velocities there; they are axes.",
    # D'Alembert's road
    "title.dalembert": "The forces in {scene} by D'Alembert's method, step by step",
    "section.count": "Equations and unknowns",
    "section.bodies": "Body by body",
    "section.reactions": "Reactions and drives",
    "section.roads": "Both roads agree",
    "scene.closed": "{scene} is a mechanism with loops or other constraints. Moving bodies: {bodies}; coordinates of "
    "the joints before the constraints tie them: {freedoms}.",
    "scene.closed.reason": "Some joints close loops: they carry no body and have no coordinate of their own.",
    "table.class": "class t",
    "table.dalembert": "by D'Alembert",
    "table.lagrange": "by Lagrange",
    "unknowns": "Every joint transmits what it does not leave free; a driven joint adds its drive.",
    "unknowns.reason": "A joint of class t has t unknown components; they are written along the axes of its own frame. "
    "The ground is body 0; the textbook counts it as body 1, and every other body one higher.",
    "unknown.drive": "drive of joint {joint}",
    "unknown.idle": "drive that a freedom in joint {joint} would need; nothing drives it, it comes out as zero",
    "unknown.passive": "what the motion of joint {joint} would need: nothing drives it",
    "unknown.force": "force in joint {joint} along its {axis} axis",
    "unknown.moment": "moment in joint {joint} about its {axis} axis",
    "unknown.coupling": "what keeps joint {joint} coupled to joint {leader}",
    "unknown.other": "component of what joint {joint} transmits",
    "loops": "The loops and other constraints tie the coordinates: these equations hold at every instant.",
    "loops.positions": "Positions, in axes of the ground or of the joint that closes the loop:",
    "loops.rates": "Rates: the derivatives of the positions with respect to time, linear in the rates.",
    "loops.reason": "Each of these joints keeps a point of one body on a point of the other: {joints}. Reached along "
    "both branches of the loop, the point has the same coordinates. Differentiated once more, the equations tie the "
    "accelerations.",
    "count": "There are {equations} equations.",
    "count.sum": "(5.18): {each} · {bodies} = {equations} equations for {bodies} moving bodies. (5.19), class times "
    "number of joints, added up: the joints have {m} = {sum} = {reactions} unknown reactions. Unknown drives: n = "
    "{drives}.",
    "count.coupled": "A joint that follows another one ({joints}) transmits one component more, that of its coupling; "
    "its class counts it.",
    "count.idle": "Freedoms that nothing drives: {number} (written in joint {joints}), such as the idle spin of a rod "
    "between two balls. n counts them, since it is the mobility; their drives come out as zero for the motion that "
    "the mechanism makes there by itself.",
    "count.passive": "Joints without a drive: {number} ({joints}). What comes out there is what the chosen motion "
    "would need, and zero for the motion that the mechanism makes by itself.",
    "count.correct": "(5.20): {equations} = {drives} + {reactions}, as many equations as unknowns: the system is "
    "correct.",
    "count.over": "(5.20) does not hold: {equations} is not {drives} + {reactions}. The mechanism is overconstrained, "
    "or drives are more or fewer than freedoms.",
    "count.plane": "The mechanism moves in a plane: forces across it and moments about axes in it are left out, and "
    "the class counts what lies in the plane (2 for a revolute or prismatic joint, which in space is of class 5).",
    "free": "Body {number}, {body}, is cut free.",
    "free.caption": "{body}, cut free: every force and couple that acts on it.",
    "free.reason": "Its frame {number} has the axes of the body and its origin in its reference joint {joint}.",
    "free.centre": " Couples with the index T are about the centre of mass T, where their forces are drawn; the "
    "moments in the formulas are about the origin O of frame {number}.",
    "frame": "Frame {number} of {body} as seen from the ground.",
    "frame.reason": "P holds the direction cosines of its axes, r with a tilde the position of its origin as a skew "
    "matrix. With them every force and moment of the body goes to the ground, (5.5): the force is multiplied by P, "
    "and so is the moment, to which r with a tilde times the force is added.",
    "moved": "How {body} moves, and what that takes.",
    "moved.reason": "The inertia force is minus mass times acceleration: of the centre of mass in (5.11), of the "
    "origin of the frame in (5.16). P transposed turns (5.11) into the axes of the body, (5.12) and (5.13). The "
    "moment (5.14) is minus the inertia times the angular acceleration, minus the gyroscopic term, plus the arm of "
    "the centre of mass crossed with (5.16).",
    "erratum.5.1b": "The second component of the moment reads {reads}; it is {right}: the first index is the frame, "
    "the second the body, the third the axis. Check: all other components of (5.1) begin with jj.",
    "erratum.5.3": "One letter stands for the skew matrix (5.2) and for the shift of a bivector (5.3); they are r "
    "with a tilde, three rows and columns, and R with a bar, six. Check: in (5.5) the shift multiplies a bivector, "
    "which has six rows.",
    "erratum.5.16": "The text has a position in place of an acceleration. (5.11) is right.",
    "erratum.5.16.check": "Check in numbers, at the state that the section on reactions lists: put into (5.14), the "
    "text gives {left} {wrong}; the motion needs {left} {right}.",
    "bivectors": "What acts on {body}, each force over its moment about the origin of its frame.",
    "bivectors.reason": "Actions A: weight, loads, springs, friction. Inertia D: minus mass times acceleration of the "
    "centre of mass, and the moment of (5.14). Reactions R in the reference joint, and with a star those in other "
    "joints, opposite to what acts on the neighbour.",
    "balance": "{body} is in equilibrium.",
    "balance.reason": "With the inertia forces counted as forces, all bivectors of the body add up to zero.",
    "solved": "The equations are solved for all reactions and drives.",
    "solved.reason": "From the tip to the ground: the last body's equations hold only what its own joint transmits.",
    "reactions": "In numbers:",
    "reactions.open": "At the state above:",
    "reactions.closed": "With loops all equations are coupled, and no body can be solved before the others; at the "
    "state above, whose rates and accelerations the loops allow:",
    "reactions.least": "The values are not unique; these are the least ones.",
    "reactions.reason": "The same system, solved in numbers.",
    "roads": "Lagrange's road gives the same drives.",
    "roads.open": "The solution above and Lagrange's equations are the same functions, and put into (5.18) the "
    "solution leaves nothing.",
    "roads.drives": "(5.18), solved exactly for the drives, and Lagrange's equations with multipliers give the same "
    "functions.",
    "roads.joints": "What the reactions and drives do along the motion of each joint is what virtual work asks for.",
    "roads.power": "All reactions together have the power of the drives and of what acts in the joints.",
    "roads.momentum": "What the ground exerts, with weights and loads, is the rate of the momentum.",
    "roads.proved": "Drives compared: {names}. Proved at {points} random points over {primes} random prime fields; "
    "the chance of error is below {chance}.",
    "roads.numbers": "In numbers, at the state above:",
    "roads.reason": "Lagrange's equations know no reactions, because these do no work; D'Alembert's find them all. "
    "Both share the scene, and nothing else.",
    # exercises and the page
    "page.contents": "Contents",
    "section.live": "Try it",
    "section.solutions": "Solutions",
    "exercise.how": "Results are left out here: write each of them into its box, in plain text such as "
    "2*m1*h1^2*cos(q1 + q2)*q1'^2 or in LaTeX. Any equal form counts. The page compares values and "
    "needs no network.",
    "exercise.script": "The boxes check answers with JavaScript, which is off here; the solutions are at the end.",
    "exercise.example": "for example 2*m1*h1^2*cos(q1 + q2)*q1'^2",
    "exercise.check": "Check",
    "exercise.hint": "Hint",
    "exercise.solution": "Solution",
    "exercise.ask": "What is {left}?",
    "exercise.later": "Written out, this follows from what is asked; it stands with the solutions.",
    "exercise.solved": "{left} is found like this.",
    "exercise.hint.square": "Square both velocities, add them, and use sin² + cos² = 1 and the addition formula.",
    "exercise.hint.potential": "Mass times free fall times height; the height is in the positions.",
    "exercise.hint.momentum": "Differentiate with respect to this rate alone; everything else counts as constant.",
    "exercise.hint.slope": "Differentiate with respect to this coordinate alone; the rates count as constants.",
    "exercise.hint.equation": "The rate of the momentum less the slope of the Lagrangian.",
    "exercise.hint.coefficients": "Read it off the equations of motion: it is what multiplies the accelerations or "
    "rates of its "
    "indices, with its sign.",
    "exercise.hint.bivectors": "Put the motion of the body into (5.14); its inertia, angular velocity and (5.16) "
    "stand above.",
    "exercise.hint.solved": "Begin at the last body: its equation of moments about the axis holds the drive alone.",
    "answer.right": "Right.",
    "answer.shifted": "Right; your zero of potential energy lies elsewhere, which adds a constant and is free.",
    "answer.turned": "Not yet: all of it has the opposite sign.",
    "answer.factor": "Not yet: yours is {factor} times the result.",
    "answer.rounded": "Not yet: it is right to some digits only; write numbers exactly.",
    "answer.numbers": "Not yet: it is right for the numbers of this scene only; write the symbols in their place.",
    "answer.wrong": "Not yet: it has another value.",
    "answer.undefined": "This has no value: it divides by zero, or takes the root of a negative number.",
    "fault.empty": "Nothing is written here.",
    "fault.quantity": "{text} only names a result; write it out in the symbols of the mechanism.",
    "fault.time": "Derivatives are read of coordinates only, such as q' or d/dt q; carry out the others first.",
    "fault.name": "{text} is no symbol here.",
    "fault.ambiguous": "{text} can be read in several ways; put spaces between factors.",
    "fault.character": "{text} has no place in a formula.",
    "fault.bracket": "This bracket is not closed.",
    "fault.end": "Something is missing at the end.",
    "fault.here": "{text} does not fit here.",
    "fault.power": "An exponent is an integer up to 32, or 1/2; more than one digit in braces.",
    "fault.argument": "sin and cos need an angle: sin(q).",
    "fault.division": "Does this divide by one factor or by all? Write a/(b c) or (a/b) c.",
    "fault.dots": "{text} carries no dots; only coordinates do.",
    "fault.deep": "This is too long or nests too deep.",
}
