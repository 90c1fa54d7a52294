/* Tactus: the controller that finds an object by touch, and its pose estimator, for C and C++.
 *
 * Generated from firmware/library/src by cbindgen; do not edit. How to build and link: docs/library.md.
 *
 * What holds for every function:
 * - SI units; names end in them. The world is z up, its origin on the table top's centre.
 * - A pointer is NULL only where its comment allows it. One that is not points to what its type says and stays valid
 *   during the call; nothing is kept from it but the memory given to a `create` function. NULL, crooked pointers,
 *   values out of range and memory that is no handle are answered with a `TactusResult`, never with a crash.
 * - No allocation, no global state, no clock, no lock. One handle is used by one thread or interrupt at a time;
 *   functions that take it as const may run at the same time as each other. Different handles know nothing of each
 *   other. A handle may go from thread to thread if your hand-over is a memory barrier (a mutex, a queue).
 * - Every call is bounded; none waits.
 */

#ifndef TACTUS_H
#define TACTUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Version of this interface: it grows by one whenever a struct, a constant or a function changes its meaning.
#define TACTUS_ABI_VERSION 3

/// Bytes that are enough for a controller on every target; `tactus_controller_size` says how many one takes here.
#define TACTUS_CONTROLLER_SIZE 53248

/// `TACTUS_CONTROLLER_SIZE` in words of 64 bits.
#define TACTUS_CONTROLLER_WORDS 6656

/// Alignment that a controller's memory needs, bytes.
#define TACTUS_CONTROLLER_ALIGN 8

/// Most events of one tick.
#define TACTUS_EVENTS_MAX 8

/// Bytes that are enough for an estimator on every target; `tactus_estimator_size` says how many one takes here.
#define TACTUS_ESTIMATOR_SIZE 28672

/// `TACTUS_ESTIMATOR_SIZE` in words of 64 bits.
#define TACTUS_ESTIMATOR_WORDS 3584

/// Alignment that an estimator's memory needs, bytes.
#define TACTUS_ESTIMATOR_ALIGN 8

/// Most knots of one trajectory.
#define TACTUS_KNOTS_MAX 48

/// `guarded_from` of a trajectory without a guarded part.
#define TACTUS_UNGUARDED 255

/// Length of one tick, microseconds: `tactus_controller_tick` is to be called this often.
#define TACTUS_TICK_US 2000

/// Ticks without readings after which the controller lets go of the robot.
#define TACTUS_SILENCE_TICKS_MAX 20

/// Joints of the arm.
#define TACTUS_ARM_JOINTS 7

/// Motors of the hand: F1, F2, F3, spread.
#define TACTUS_HAND_MOTORS 4

/// Fingers of the hand: F1, F2, F3.
#define TACTUS_FINGERS 3

/// Tactile pads: fingertips F1, F2, F3, and the palm.
#define TACTUS_PADS 4

/// Cells of one tactile pad.
#define TACTUS_PAD_CELLS 24

/// All seven arm angles were measured.
#define TACTUS_VALID_ARM 127

/// All four motor positions were measured.
#define TACTUS_VALID_MOTORS 1920

/// All three inner-link angles were measured.
#define TACTUS_VALID_INNER 14336

/// All four motor efforts were measured. The controller does without.
#define TACTUS_VALID_EFFORTS 245760

/// All three fingertip torques were measured.
#define TACTUS_VALID_TIPS 1835008

/// Everything was measured.
#define TACTUS_VALID_ALL 2097151

/// What a function answers. Anything but `TACTUS_RESULT_OK` is a mistake of the caller; the handle stays as it was.
enum TactusResult
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Done.
    TACTUS_RESULT_OK = 0,
    /// A pointer that is needed is NULL.
    TACTUS_RESULT_NULL_POINTER = 1,
    /// A pointer is not aligned for what it points to.
    TACTUS_RESULT_MISALIGNED = 2,
    /// The memory is smaller than what is to live in it.
    TACTUS_RESULT_TOO_SMALL = 3,
    /// The handle was not made by the `create` function of its kind.
    TACTUS_RESULT_NOT_CREATED = 4,
    /// A value makes no sense: not finite, out of its range, or no constant of its enumeration.
    TACTUS_RESULT_BAD_VALUE = 5,
    /// Not now: an update is running. Finish it first.
    TACTUS_RESULT_BUSY = 6,
    /// No room for more evidence: begin a new touch (the oldest is forgotten) or clear the estimator.
    TACTUS_RESULT_FULL = 7,
    /// Nothing to tell yet: no mission has begun.
    TACTUS_RESULT_NOT_YET = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusResult TactusResult;
#else
typedef int32_t TactusResult;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What a motor of the hand is told to do.
enum TactusHandMode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// No current; the worm gears of the fingers hold by themselves. `value` is 0.
    TACTUS_HAND_MODE_IDLE = 0,
    /// Move to the joint angle `value`, radians, at the drive's own speed and hold it.
    TACTUS_HAND_MODE_POSITION = 1,
    /// Move at the joint speed `value`, rad/s, positive closes; 0 holds.
    TACTUS_HAND_MODE_VELOCITY = 2,
    /// Push with the joint torque `value`, newton-metres, positive closes.
    TACTUS_HAND_MODE_TORQUE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusHandMode TactusHandMode;
#else
typedef uint8_t TactusHandMode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What a motion is for.
enum TactusPurpose
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Come down beside the object to touch it; the descent is guarded.
    TACTUS_PURPOSE_TOUCH = 0,
    /// Come down over the object to grasp it; the descent is guarded.
    TACTUS_PURPOSE_GRASP = 1,
    /// Lift the grasped object, carry it by the displacement, set it down.
    TACTUS_PURPOSE_TRANSPORT = 2,
    /// Straight up and away; not guarded.
    TACTUS_PURPOSE_RETREAT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusPurpose TactusPurpose;
#else
typedef uint8_t TactusPurpose;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What happened.
enum TactusEventKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// A phase began: `phase`.
    TACTUS_EVENT_KIND_PHASE = 0,
    /// A touch began: `candidate`, `information_nats`.
    TACTUS_EVENT_KIND_TOUCH = 1,
    /// A finger felt something: `finger`, `inner_rad`, `yes` if it was while the hand came down.
    TACTUS_EVENT_KIND_CONTACT = 2,
    /// The belief was corrected: `belief`, `evaluations`, `modes`, `yes` if the next step is the grasp.
    TACTUS_EVENT_KIND_UPDATED = 3,
    /// The simulation agreed (`yes`) with what was felt, or not.
    TACTUS_EVENT_KIND_CONFIRMED = 4,
    /// The planner refused a motion: `refusal`.
    TACTUS_EVENT_KIND_REFUSED = 5,
    /// The mission ended: `outcome`.
    TACTUS_EVENT_KIND_FINISHED = 6,
    /// The object slips in the hand: `finger`, `sureness`, `grip_nm`.
    TACTUS_EVENT_KIND_SLIP = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusEventKind TactusEventKind;
#else
typedef uint8_t TactusEventKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Phase of the mission.
enum TactusPhase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Waits for a mission and for the first readings.
    TACTUS_PHASE_INITIALISE = 0,
    /// Chooses the next touch and waits for a trajectory.
    TACTUS_PHASE_PLAN = 1,
    /// Moves, comes down and closes the fingers, guarded.
    TACTUS_PHASE_TRIAL = 2,
    /// Fits the pose to all evidence.
    TACTUS_PHASE_UPDATE = 3,
    /// Comes down over the object and takes it.
    TACTUS_PHASE_GRASP = 4,
    /// Carries it.
    TACTUS_PHASE_TRANSPORT = 5,
    /// Lets go and withdraws.
    TACTUS_PHASE_RELEASE = 6,
    /// The object stands at its goal.
    TACTUS_PHASE_DONE = 7,
    /// Gave up with the robot in its safe state.
    TACTUS_PHASE_FAILED = 8,
    /// Something is wrong; the robot is in its safe state.
    TACTUS_PHASE_FAULT = 9,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusPhase TactusPhase;
#else
typedef uint8_t TactusPhase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Why the planner has no trajectory.
enum TactusRefusal
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// It has one.
    TACTUS_REFUSAL_NONE = 0,
    /// No joint angles within the limits put the hand there.
    TACTUS_REFUSAL_NO_INVERSE_KINEMATICS = 1,
    /// The goal is beyond the arm's reach.
    TACTUS_REFUSAL_OUT_OF_REACH = 2,
    /// The robot is in collision where it stands.
    TACTUS_REFUSAL_START_IN_COLLISION = 3,
    /// The robot would be in collision at the goal.
    TACTUS_REFUSAL_GOAL_IN_COLLISION = 4,
    /// The search found no collision-free path.
    TACTUS_REFUSAL_NO_PATH = 5,
    /// The path needs more knots than a trajectory holds.
    TACTUS_REFUSAL_TOO_MANY_KNOTS = 6,
    /// The request holds a value that is not finite.
    TACTUS_REFUSAL_NON_FINITE = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusRefusal TactusRefusal;
#else
typedef uint8_t TactusRefusal;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How a mission ended.
enum TactusEnd
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// It has not ended.
    TACTUS_END_NOT_YET = 0,
    /// The object was put down at its goal, as far as the controller can tell.
    TACTUS_END_TRANSPORTED = 1,
    /// The task failed; `failure` says why.
    TACTUS_END_FAILED = 2,
    /// The robot was made safe; `fault` says why.
    TACTUS_END_FAULT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusEnd TactusEnd;
#else
typedef uint8_t TactusEnd;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Why a mission gave up although nothing is broken.
enum TactusFailure
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// It did not.
    TACTUS_FAILURE_NONE = 0,
    /// The planner refused every motion; `refusal` is its last reason.
    TACTUS_FAILURE_NO_PLAN = 1,
    /// The touches allowed did not make the pose certain enough to grasp.
    TACTUS_FAILURE_NOT_CONFIDENT = 2,
    /// Nothing was felt where the object should be.
    TACTUS_FAILURE_NOTHING_FELT = 3,
    /// The fingers closed without holding the object.
    TACTUS_FAILURE_GRASP_MISSED = 4,
    /// The object was lost on the way.
    TACTUS_FAILURE_OBJECT_LOST = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusFailure TactusFailure;
#else
typedef uint8_t TactusFailure;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What made the controller stop the robot.
enum TactusFault
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Nothing did.
    TACTUS_FAULT_NONE = 0,
    /// No readings for `TACTUS_SILENCE_TICKS_MAX` ticks.
    TACTUS_FAULT_HOST_SILENT = 1,
    /// A needed reading was not measured (or not finite) for several ticks.
    TACTUS_FAULT_SENSOR_INVALID = 2,
    /// `joint` left its range.
    TACTUS_FAULT_JOINT_LIMIT = 3,
    /// `joint` moved faster than its limit.
    TACTUS_FAULT_JOINT_SPEED = 4,
    /// `joint` did not follow its reference.
    TACTUS_FAULT_TRACKING = 5,
    /// The mission makes no sense.
    TACTUS_FAULT_BAD_SETUP = 6,
    /// The mission is of another version of the wire's messages; cannot happen through this interface.
    TACTUS_FAULT_SCHEMA_MISMATCH = 7,
    /// A request was not answered within 10 s.
    TACTUS_FAULT_HOST_SLOW = 8,
    /// The mission asks for what is not compiled in; cannot happen with this library.
    TACTUS_FAULT_NOT_IN_IMAGE = 9,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusFault TactusFault;
#else
typedef uint8_t TactusFault;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Whether a belief is good enough to grasp by (3 mm and 1.5 degrees, 99 %), and if not, why.
enum TactusReadiness
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Narrow enough, explains the evidence, and checked by one contact more than there are unknowns.
    TACTUS_READINESS_READY = 0,
    /// Nothing has been touched yet.
    TACTUS_READINESS_NO_CONTACT = 1,
    /// No pose explains all contacts and free links: something moved, or a reading was false.
    TACTUS_READINESS_INCONSISTENT = 2,
    /// As many unknowns as contacts: anything can be explained, so nothing is checked yet.
    TACTUS_READINESS_UNCHECKED = 3,
    /// Several poses far apart explain the evidence.
    TACTUS_READINESS_AMBIGUOUS = 4,
    /// One pose, but not exact enough.
    TACTUS_READINESS_TOO_WIDE = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusReadiness TactusReadiness;
#else
typedef uint8_t TactusReadiness;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Kinds of object.
enum TactusShapeKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// A rectangular box that stands on its lower face.
    TACTUS_SHAPE_KIND_CUBOID = 0,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusShapeKind TactusShapeKind;
#else
typedef uint8_t TactusShapeKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What felt a contact.
enum TactusToucher
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// A link of finger 1.
    TACTUS_TOUCHER_F1 = 0,
    /// A link of finger 2.
    TACTUS_TOUCHER_F2 = 1,
    /// A link of finger 3.
    TACTUS_TOUCHER_F3 = 2,
    /// The palm.
    TACTUS_TOUCHER_PALM = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusToucher TactusToucher;
#else
typedef uint8_t TactusToucher;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How a contact came about, which says how exact it is.
enum TactusContactKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// A finger closed until it felt something (0.6 mm standard deviation).
    TACTUS_CONTACT_KIND_CLOSING = 0,
    /// The hand came down until something was felt (1.5 mm).
    TACTUS_CONTACT_KIND_LANDING = 1,
    /// A finger of a closed grasp, pressed harder (1.0 mm).
    TACTUS_CONTACT_KIND_GRASP = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TactusContactKind TactusContactKind;
#else
typedef uint8_t TactusContactKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A controller; lives in memory of yours, from `tactus_controller_create` on.
typedef struct TactusController TactusController;

/// A pose estimator; lives in memory of yours, from `tactus_estimator_create` on.
typedef struct TactusEstimator TactusEstimator;

/// What the object is.
typedef struct TactusShape {
    /// A `TactusShapeKind`.
    uint8_t kind;
    /// Half the edge lengths along the object's x, y, z, metres, each above 0.
    float half_extents_m[3];
} TactusShape;

/// Pose of an object that stands upright on the table, in the world frame: z up, origin on the table top's centre.
typedef struct TactusPose {
    /// World x of the object's centroid, metres.
    float x_m;
    /// World y of the object's centroid, metres.
    float y_m;
    /// Rotation about the world's z axis, radians, positive anticlockwise seen from above.
    float phi_rad;
} TactusPose;

/// How far a guess may be off: the true pose lies within guess +- these. A component with 0 is known exactly.
typedef struct TactusInterval {
    /// Half width in x, metres, 0 or more.
    float x_m;
    /// Half width in y, metres, 0 or more.
    float y_m;
    /// Half width in phi, radians, 0 or more.
    float phi_rad;
} TactusInterval;

/// A mission: all that the controller is told about the object's place; the rest it must feel. The robot's base stands where
/// the robot's description has it: world x = -0.05 m, y = -0.6 m, yaw = pi/2.
typedef struct TactusSetup {
    /// What the object is.
    struct TactusShape shape;
    /// Guess of the object's pose.
    struct TactusPose guess;
    /// The true pose lies within guess +- interval.
    struct TactusInterval interval;
    /// Where to put it: displacement from where it stands, world x and y, metres.
    float displacement_m[2];
    /// Mass of the object, kilograms.
    float mass_kg;
    /// Most touches before the mission gives up, 1 or more.
    uint8_t trials_max;
} TactusSetup;

/// Joint readings of one tick. A value without its bit in `valid` is not used; one that is not finite makes the whole
/// reading count as not measured.
typedef struct TactusReadings {
    /// Arm joint angles J1..J7, radians.
    float arm_q_rad[TACTUS_ARM_JOINTS];
    /// Motor positions F1, F2, F3, spread as joint angles, radians: motor angle over the gear ratio to the inner link
    /// or the spread. Positive closes.
    float motor_q_rad[TACTUS_HAND_MOTORS];
    /// Inner-link angles F1, F2, F3 by the secondary encoders, radians.
    float inner_q_rad[TACTUS_FINGERS];
    /// Motor efforts F1, F2, F3, spread as torques at the joint, newton-metres, positive closes.
    float effort_nm[TACTUS_HAND_MOTORS];
    /// Fingertip torques F1, F2, F3 about the distal joint, newton-metres; positive where the world pushes the tip open.
    float tip_torque_nm[TACTUS_FINGERS];
    /// What was measured: bits 0-6 arm, 7-10 motors, 11-13 inner links, 14-17 efforts, 18-20 tips (`TACTUS_VALID_...`).
    uint32_t valid;
} TactusReadings;

/// One image of one tactile pad.
typedef struct TactusImage {
    /// Tick at which the pad was scanned.
    uint32_t stamp;
    /// Pressure per cell, N/cm^2, row by row. Values below 0 and values that are no number count as 0.
    float pressure_n_cm2[TACTUS_PAD_CELLS];
    /// 0, 1, 2 = fingertips F1, F2, F3; 3 = palm.
    uint8_t pad;
} TactusImage;

/// State of the arm at one instant of a trajectory; quintic between two of them.
typedef struct TactusKnot {
    /// Time since the trajectory's start, seconds; the first at 0, the next each at least a tick later.
    float t_s;
    /// Joint angles J1..J7, radians.
    float q_rad[TACTUS_ARM_JOINTS];
    /// Joint velocities, rad/s.
    float qd_rad_s[TACTUS_ARM_JOINTS];
    /// Joint accelerations, rad/s^2.
    float qdd_rad_s2[TACTUS_ARM_JOINTS];
} TactusKnot;

/// The planner's answer. A trajectory that the arm cannot follow (limits, gaps, motion at its end) counts as refused.
typedef struct TactusPlanAnswer {
    /// The knots, `knot_count` of them; copied before `tactus_controller_tick` returns. Not looked at in a refusal.
    const struct TactusKnot *knots;
    /// Number of knots, at most `TACTUS_KNOTS_MAX`.
    uint16_t knot_count;
    /// Number of the request that this answers.
    uint16_t request;
    /// From this knot on a contact ends the motion; `TACTUS_UNGUARDED`: nowhere.
    uint8_t guarded_from;
    /// A `TactusRefusal`: why there is no trajectory, or `TACTUS_REFUSAL_NONE`.
    uint8_t refusal;
} TactusPlanAnswer;

/// What the simulation foretells.
typedef struct TactusRollout {
    /// Inner-link angle at which each finger first touches, radians; not looked at where it touches nothing.
    float onset_inner_rad[TACTUS_FINGERS];
    /// Which fingers touch: bits 0, 1, 2 = F1, F2, F3.
    uint8_t touching;
    /// Number of the request that this answers.
    uint16_t request;
} TactusRollout;

/// What came in since the last tick. Everything may be missing.
typedef struct TactusInputs {
    /// Joint readings; NULL if none came. After `TACTUS_SILENCE_TICKS_MAX` ticks without, the controller lets go.
    const struct TactusReadings *readings;
    /// New images of the pads, `image_count` of them, each of another pad.
    const struct TactusImage *images;
    /// The planner's answer, or NULL.
    const struct TactusPlanAnswer *plan;
    /// The simulation's answer, or NULL.
    const struct TactusRollout *rollout;
    /// Number of images, at most `TACTUS_PADS`.
    uint32_t image_count;
} TactusInputs;

/// Command of one motor of the hand; values at the joint (inner link or spread).
typedef struct TactusHandCommand {
    /// What `value` means.
    TactusHandMode mode;
    /// Radians, rad/s or newton-metres.
    float value;
} TactusHandCommand;

/// Commands of one tick.
typedef struct TactusCommands {
    /// Arm joint torques J1..J7, newton-metres, within the joints' limits.
    float arm_tau_nm[TACTUS_ARM_JOINTS];
    /// Motors of the hand F1, F2, F3, spread.
    struct TactusHandCommand hand[TACTUS_HAND_MOTORS];
} TactusCommands;

/// Where the hand goes, pointing straight down, relative to the believed object.
typedef struct TactusPlacement {
    /// The hand's axis and yaw in the object's frame; at yaw 0 the hand's +x is the object's +x.
    struct TactusPose hand_in_object;
    /// Height of the palm's face above the object's top, metres.
    float palm_height_m;
} TactusPlacement;

/// Finger angles before closing.
typedef struct TactusPreshape {
    /// Inner links F1, F2, F3, radians.
    float inner_rad[TACTUS_FINGERS];
    /// Spread, radians.
    float spread_rad;
} TactusPreshape;

/// A question to the planner. Answer it with a `TactusPlanAnswer` in a later tick, within 10 s.
typedef struct TactusPlanRequest {
    /// Arm joint angles to start from, radians.
    float start_q_rad[TACTUS_ARM_JOINTS];
    /// Where the hand is to go (touch and grasp).
    struct TactusPlacement placement;
    /// Finger angles on the way.
    struct TactusPreshape preshape;
    /// Displacement of the object in the world, metres: now (transport), or next (grasp).
    float displacement_m[2];
    /// Believed pose of the object.
    struct TactusPose belief;
    /// Upper triangle of its covariance: xx, xy, xphi, yy, yphi, phiphi (m^2, m rad, rad^2).
    float covariance[6];
    /// Number of this request; the answer carries it.
    uint16_t request;
    /// What the motion is for.
    TactusPurpose purpose;
    /// Number of the candidate touch, 255 = none.
    uint8_t touch;
} TactusPlanRequest;

/// A question to a simulation of the hand: what would this touch feel if the object stood at `pose`? It confirms the
/// belief before the grasp. Answer it with a `TactusRollout` in a later tick, within 10 s.
typedef struct TactusRolloutRequest {
    /// Hypothesised pose of the object.
    struct TactusPose pose;
    /// Arm joint angles during the touch, radians.
    float arm_q_rad[TACTUS_ARM_JOINTS];
    /// Finger angles from which to close.
    struct TactusPreshape preshape;
    /// Closing speed of each finger's inner link, rad/s, for `ticks`; 0 = does not close.
    float closing_rad_s[TACTUS_FINGERS];
    /// Ticks of closing to foretell, 2 ms each.
    uint16_t ticks;
    /// Number of this request; the answer carries it.
    uint16_t request;
} TactusRolloutRequest;

/// How a mission ended, and why.
typedef struct TactusOutcome {
    /// How.
    TactusEnd end;
    /// Why it failed.
    TactusFailure failure;
    /// Why there was no plan.
    TactusRefusal refusal;
    /// What was wrong.
    TactusFault fault;
    /// The arm joint that the fault is about, 0..6; else 255.
    uint8_t joint;
} TactusOutcome;

/// Something happened. Only the fields that its kind names say anything.
typedef struct TactusEvent {
    /// When.
    uint32_t tick;
    /// What, and which of the fields below tell more.
    TactusEventKind kind;
    /// The phase that began.
    TactusPhase phase;
    /// Why the planner refused.
    TactusRefusal refusal;
    /// How the mission ended.
    struct TactusOutcome outcome;
    /// Yes or no, as the kind says.
    bool yes;
    /// Number of the touch among the candidates.
    uint8_t candidate;
    /// 0, 1, 2 = F1, F2, F3; 3 = palm.
    uint8_t finger;
    /// Distinct poses that explain the evidence.
    uint8_t modes;
    /// Error evaluations of the update.
    uint16_t evaluations;
    /// Information that the touch is expected to give, nats.
    float information_nats;
    /// Inner-link angle at the moment of contact, radians.
    float inner_rad;
    /// How sure it is that the object slips, 0.5 to 1.
    float sureness;
    /// What the finger is to push with from now on, newton-metres at its inner joint.
    float grip_nm;
    /// Believed pose.
    struct TactusPose belief;
} TactusEvent;

/// What goes out after a tick.
typedef struct TactusOutputs {
    /// Joint commands.
    struct TactusCommands commands;
    /// A question to the planner, if `has_plan_request`.
    struct TactusPlanRequest plan_request;
    /// A question to the simulation, if `has_rollout_request`.
    struct TactusRolloutRequest rollout_request;
    /// What happened, `event_count` entries; the rest is empty.
    struct TactusEvent events[TACTUS_EVENTS_MAX];
    /// Number of events.
    uint32_t event_count;
    /// Is there a question to the planner?
    bool has_plan_request;
    /// Is there a question to the simulation?
    bool has_rollout_request;
    /// Ten times a second: time to report status (`tactus_controller_belief`).
    bool status_due;
    /// Phase of the mission after this tick.
    TactusPhase phase;
    /// How the mission ended, if it did.
    struct TactusOutcome outcome;
} TactusOutputs;

/// Where the object is believed to stand.
typedef struct TactusBelief {
    /// The believed pose: the mean over all poses that explain the evidence.
    struct TactusPose pose;
    /// Covariance over x (m), y (m), phi (rad), symmetric.
    float covariance[3][3];
    /// Half width that holds 99 % of the belief in the horizontal direction of the largest spread, metres.
    float half_width_m;
    /// Half width in yaw that holds 99 % of the belief, radians.
    float half_width_rad;
    /// Is it good enough to grasp by?
    TactusReadiness readiness;
    /// Distinct poses that explain the evidence.
    uint8_t modes;
    /// Contacts that were fitted.
    uint16_t contacts;
    /// Contacts among them more than three standard deviations off at the best pose.
    uint16_t outliers;
    /// Links known to be free that would be deep inside the object at the best pose.
    uint16_t collisions;
} TactusBelief;

/// What is known before the first touch: the pose lies in guess +- interval, all equally likely.
typedef struct TactusPrior {
    /// What the object is.
    struct TactusShape shape;
    /// Middle of the region.
    struct TactusPose guess;
    /// Half widths of the region; a component with 0 is known exactly.
    struct TactusInterval interval;
} TactusPrior;

/// A place and an orientation in the world frame.
typedef struct TactusTransform {
    /// Origin, metres.
    float position_m[3];
    /// Rotation as a unit quaternion, scalar last: i, j, k, w.
    float rotation_ijkw[4];
} TactusTransform;

/// Where the hand is and how it is bent. Hand frame: origin on the mounting plane, z out of the palm, F3 at -x.
typedef struct TactusHand {
    /// World-from-hand transform.
    struct TactusTransform world_from_hand;
    /// Inner links F1, F2, F3, radians; 0 = in the palm's plane, positive closes.
    float inner_rad[TACTUS_FINGERS];
    /// Tips F1, F2, F3 against their inner links, radians; 0 = fully open.
    float distal_rad[TACTUS_FINGERS];
    /// Spread, radians; 0 = F1 and F2 opposite F3.
    float spread_rad;
} TactusHand;

/// One pose that explains the evidence.
typedef struct TactusMode {
    /// The pose.
    struct TactusPose pose;
    /// Its own covariance over x (m), y (m), phi (rad), symmetric.
    float covariance[3][3];
    /// Share of the belief, 0..1.
    float weight;
    /// The error there, in chi-squared units.
    float error;
} TactusMode;

/// Memory for one controller, static or part of a struct of yours; too large for most stacks. Its content is not
/// yours: `tactus_controller_create` gives the handle.
typedef struct TactusControllerMemory {
    /// Not to be used.
    uint64_t words[TACTUS_CONTROLLER_WORDS];
} TactusControllerMemory;

/// Memory for one estimator. Its content is not yours: `tactus_estimator_create` gives the handle.
typedef struct TactusEstimatorMemory {
    /// Not to be used.
    uint64_t words[TACTUS_ESTIMATOR_WORDS];
} TactusEstimatorMemory;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// `TACTUS_ABI_VERSION` of the library that is linked; compare it with the header's before anything else.
uint32_t tactus_abi_version(void);

/// Bytes that a controller takes on this target, at most `TACTUS_CONTROLLER_SIZE`.
size_t tactus_controller_size(void);

/// Alignment that a controller's memory needs on this target, bytes, at most `TACTUS_CONTROLLER_ALIGN`.
size_t tactus_controller_align(void);

/// Makes a controller in your memory. There is nothing to destroy: when the handle is not used any more, the memory is
/// yours again.
///
/// `memory` has `memory_bytes` bytes (`TACTUS_CONTROLLER_SIZE` are enough) and is aligned to
/// `TACTUS_CONTROLLER_ALIGN`; it must not move while the handle is in use. `controller` receives the handle.
TactusResult tactus_controller_create(void *memory,
                                      size_t memory_bytes,
                                      struct TactusController **controller);

/// Begins a mission at the next tick and forgets any before it.
///
/// `TACTUS_RESULT_BAD_VALUE` if it makes no sense: not finite, half extents of 0, anything beyond 10 m or 10 kg, no
/// touch allowed.
TactusResult tactus_controller_begin(struct TactusController *controller,
                                     const struct TactusSetup *setup);

/// One tick. Call it every `TACTUS_TICK_US`, also when no readings came: silence is what it watches for.
///
/// `now` counts ticks from the first one of a mission on; each call's is larger than the one before. Unless the answer
/// is `TACTUS_RESULT_OK`, nothing was done and `outputs`, if it can be written at all, holds commands that do nothing
/// (no torque, hand idle): stop the robot.
TactusResult tactus_controller_tick(struct TactusController *controller,
                                    uint32_t now,
                                    const struct TactusInputs *inputs,
                                    struct TactusOutputs *outputs);

/// Where the object is believed to stand. `TACTUS_RESULT_NOT_YET` before the first tick of a mission.
TactusResult tactus_controller_belief(const struct TactusController *controller, struct TactusBelief *belief);

/// Phase of the mission.
TactusResult tactus_controller_phase(const struct TactusController *controller, TactusPhase *phase);

/// How the mission ended, if it did.
TactusResult tactus_controller_outcome(const struct TactusController *controller,
                                       struct TactusOutcome *outcome);

/// Bytes that an estimator takes on this target, at most `TACTUS_ESTIMATOR_SIZE`.
size_t tactus_estimator_size(void);

/// Makes an estimator in your memory, with no evidence yet. There is nothing to destroy.
///
/// `memory` has `memory_bytes` bytes (`TACTUS_ESTIMATOR_SIZE` are enough) and is aligned to `TACTUS_ESTIMATOR_ALIGN`;
/// it must not move while the handle is in use. `estimator` receives the handle.
TactusResult tactus_estimator_create(void *memory,
                                     size_t memory_bytes,
                                     const struct TactusPrior *prior,
                                     struct TactusEstimator **estimator);

/// Begins a touch: evidence added from now on belongs to it. The touch 8 back is forgotten.
TactusResult tactus_estimator_begin_touch(struct TactusEstimator *estimator);

/// Forgets all evidence and starts from the prior again: the object was moved.
TactusResult tactus_estimator_clear(struct TactusEstimator *estimator);

/// Evidence: with the hand like this, `toucher` (a `TactusToucher`) felt the object; `kind` (a `TactusContactKind`)
/// says how.
TactusResult tactus_estimator_add_contact(struct TactusEstimator *estimator,
                                          const struct TactusHand *hand,
                                          uint8_t toucher,
                                          uint8_t kind);

/// Evidence: with the hand like this, the palm and the fingers marked in `fingers` (bits 0, 1, 2 = F1, F2, F3) were
/// clear of the object.
TactusResult tactus_estimator_add_free(struct TactusEstimator *estimator,
                                       const struct TactusHand *hand,
                                       uint8_t fingers);

/// Evidence: from the hand like this, `finger` (0, 1, 2 = F1, F2, F3) closed to the inner angle `end_inner_rad`,
/// radians, without touching anything.
TactusResult tactus_estimator_add_free_sweep(struct TactusEstimator *estimator,
                                             const struct TactusHand *hand,
                                             uint8_t finger,
                                             float end_inner_rad);

/// Fits the pose to all evidence, a slice at a time: `work_max` (1 or more) bounds a slice, in units of about a hundred
/// instructions of a Cortex-M4F; a slice may take one evaluation of the error more. The first slice begins an update;
/// `done` becomes true when it is finished and the belief is new. How it is sliced changes nothing in the result.
///
/// While an update runs no evidence can be added (`TACTUS_RESULT_BUSY`).
TactusResult tactus_estimator_update(struct TactusEstimator *estimator,
                                     uint32_t work_max,
                                     bool *done);

/// Where the object is believed to stand: after the last whole update, or from the prior alone.
TactusResult tactus_estimator_belief(const struct TactusEstimator *estimator, struct TactusBelief *belief);

/// One of the distinct poses that explain the evidence, the best first; `index` is below `modes` of the belief.
TactusResult tactus_estimator_mode(const struct TactusEstimator *estimator,
                                   uint8_t index,
                                   struct TactusMode *mode);

/// YOU define this one. The library calls it where it finds itself broken, which no input should bring about: make
/// the robot safe (torque off, brakes) and do not return. If you do, the library keeps this thread in a loop for
/// ever. `file` has `file_bytes` bytes and no zero at its end. The handle in use is lost; others are not touched.
extern void tactus_panic(const char *file,
                         size_t file_bytes,
                         uint32_t line);

/// Where the hand of the WAM arm is and how it is bent, from joint readings (arm, motors and inner links).
///
/// `TACTUS_RESULT_BAD_VALUE` if one of these was not measured or is not finite.
TactusResult tactus_hand_from_readings(const struct TactusReadings *readings, struct TactusHand *hand);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TACTUS_H */
