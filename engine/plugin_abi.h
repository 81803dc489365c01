#pragma once

#include <stddef.h>
#include <stdint.h>

/* What stands between a host and a plug-in: plain C and doubles. No C++ object, exception or ownership crosses.

   A plug-in library exports one function, lithe_plugin_v1, which hands its types to the host. The name carries the
   major version; within v1 a table may grow at its end alone. Every table begins with struct_size, the size that its
   writer knows: a reader looks no further. Elements of arrays (lithe_marker, lithe_field, lithe_parameter ...) do not
   grow within v1. Tables and texts handed over live as long as the library.

   SI units, right-handed axes. Matrices are stored by columns; an orientation turns its own axes to world axes (columns
   are the axes). A wrench is force, then torque, in world axes. Quaternions are w, x, y, z. Equations:
   engine/README.md.

   Functions that may fail return 0 if all is well, > 0 if the state cannot be evaluated and a smaller step may help,
   < 0 if it is of no use to go on. Then they may write why into `error` (never more than error_size bytes, ended by
   zero): one sentence and, after a line feed, how to fix it. None throws. Functions that take a const object may be
   called by several threads at once. */

#define LITHE_PLUGIN_VERSION 1

#ifdef __cplusplus
extern "C" {
#endif

/* ---- parameters ---- */

enum { LITHE_NUMBER = 0, LITHE_TEXT = 1, LITHE_VECTOR = 2 };

/* A parameter that a type has. */
typedef struct lithe_field {
  const char* name;
  int32_t kind;
  int32_t size; /* of a vector; 0: any */
} lithe_field;

/* A parameter given; the host has checked its name, kind and size. What is not given keeps its default. */
typedef struct lithe_parameter {
  const char* name;
  int32_t kind;
  int32_t size;         /* of vector */
  double number;        /* LITHE_NUMBER */
  const char* text;     /* LITHE_TEXT */
  const double* vector; /* LITHE_VECTOR */
} lithe_parameter;

/* ---- joints and forces ---- */

typedef struct lithe_marker {
  double p[3]; /* position */
  double R[9]; /* marker axes to world axes */
  double v[3]; /* velocity of the point */
  double w[3]; /* angular velocity, world axes */
} lithe_marker;

/* An angle that a joint or force measures and whose whole turns the host is to count: about axis `axis` (0 x, 1 y, 2 z)
   of marker A, from the next axis to that of marker B, or (to_point = 1) to the point of B. */
typedef struct lithe_measured_angle {
  int32_t A, B, axis, to_point;
} lithe_measured_angle;

/* The rows of a joint, to be filled: g, the wrench W of a unit multiplier on each marker, ∂g/∂t, and the velocity
   terms: g_dot = Σ W·V + rate,   g_dotdot = Σ W·V_dot + bias,   V = (v, w). */
typedef struct lithe_rows {
  size_t struct_size;
  int32_t marker_count, row_count;
  double* residual; /* one a row */
  double* rate;
  double* bias;
  double* wrench;            /* [row][marker][6] */
  const double* multipliers; /* one a row; null unless the stiffness under load is asked for */
  double* stiffness;    /* then: ∂(Σ_rows W λ)/∂(marker motions), 6 rows and columns a marker; zero so far, add */
  int32_t no_stiffness; /* set it to 1 if you do not fill `stiffness`: the host differences W */
  /* One a row, 0 so far: 1 for a row on velocities alone (rolling), whose residual is 0. */
  int32_t* on_velocity;
  /* Quarter turns that the measured angles have passed since they were zero, one an angle; null: not counted. An angle
     α in (-π, π] has made round((quarter_turns - α 2/π) / 4) whole turns. */
  const double* quarter_turns;
  char* error;
  size_t error_size;
} lithe_rows;

typedef struct lithe_joint_type {
  size_t struct_size;
  const char* name;
  const lithe_field* fields;
  size_t field_count;
  int32_t marker_count, row_count;
  void* (*create)(const lithe_parameter*, size_t count, char* error, size_t error_size); /* null: refused */
  void (*destroy)(void* joint);
  /* Once, with the markers as drawn: for what the drawing fixes. May be null. */
  int32_t (*initialize)(void* joint, const lithe_marker*, char* error, size_t error_size);
  int32_t (*evaluate)(const void* joint, double time, const lithe_marker*, lithe_rows*);
  /* Writes at most `capacity` measured angles, returns how many there are. May be null: none. */
  int32_t (*angles)(const void* joint, lithe_measured_angle*, int32_t capacity);
} lithe_joint_type;

/* What a force does: wrenches on its markers, and compliant rows with a tension σ(length, speed). */
typedef struct lithe_force_rows {
  size_t struct_size;
  int32_t marker_count, row_count;
  double* load;   /* [marker][6], zero so far */
  double* wrench; /* [row][marker][6] */
  double* tension;
  double* stiffness; /* ∂σ/∂length */
  double* damping;   /* ∂σ/∂speed */
  double energy;     /* stored potential, joules */
  const double* quarter_turns;
  char* error;
  size_t error_size;
} lithe_force_rows;

typedef struct lithe_force_type {
  size_t struct_size;
  const char* name;
  const lithe_field* fields;
  size_t field_count;
  int32_t marker_count, row_count;
  void* (*create)(const lithe_parameter*, size_t count, char* error, size_t error_size);
  void (*destroy)(void* force);
  int32_t (*initialize)(void* force, const lithe_marker*, char* error, size_t error_size); /* may be null */
  int32_t (*evaluate)(const void* force, double time, const lithe_marker*, lithe_force_rows*);
  int32_t (*angles)(const void* force, lithe_measured_angle*, int32_t capacity); /* may be null */
} lithe_force_type;

/* ---- bodies ---- */

enum { LITHE_POSITION = 0, LITHE_VELOCITY = 1, LITHE_ACCELERATION = 2 }; /* levels; each contains the ones before */

typedef struct lithe_body_state {
  size_t struct_size;
  const double* q;
  const double* v;
  void* cache; /* of create_cache */
  char* error;
  size_t error_size;
} lithe_body_state;

typedef struct lithe_tangent_weights {
  double position, velocity, acceleration;
} lithe_tangent_weights;
typedef struct lithe_complex_tangent_weights {
  double position[2], velocity[2], acceleration[2]; /* real and imaginary part */
} lithe_complex_tangent_weights;

/* Blocks of the iteration matrix, by columns: 6 x 6, 6 x n, n x 6, and n diagonal entries or those of linear_pattern.
 */
typedef struct lithe_body_tangent {
  size_t struct_size;
  double* frame;
  double* frame_linear;
  double* linear_frame;
  double* linear;
  int32_t linear_count; /* entries of `linear` */
  /* Of several frames: `frame`, `frame_linear` and `linear_frame` have a block for each, one after the other; pair i
     has two, (first, second) at pair_values + pair_places[2 i] and (second, first) at pair_values + pair_places[2 i +
     1]. */
  double* pair_values;
  const int32_t* pair_places;
  int32_t pair_count;
} lithe_body_tangent;

typedef struct lithe_body_energy {
  double kinetic, elastic, gravity; /* joules */
} lithe_body_energy;

/* Motion of a marker (engine/model/marker.h). */
typedef struct lithe_marker_kinematics {
  size_t struct_size;
  lithe_marker motion;
  double bias_v[3], bias_w[3]; /* accelerations at v_dot = 0 */
  double r[3];                 /* position in body axes */
  const double* elastic;       /* 6 x n, body axes; null: not moved by linear coordinates. Lives in the cache. */
  int32_t frame;               /* of several frames, the one that the marker is fixed in; r is in its axes */
} lithe_marker_kinematics;

typedef struct lithe_body_type {
  size_t struct_size;
  const char* name;
  const lithe_field* fields;
  size_t field_count;
  void* (*create)(const lithe_parameter*, size_t count, char* error, size_t error_size);
  void (*destroy)(void* body);
  void (*coordinates)(const void* body, int32_t* frames, int32_t* linear); /* number of frames; length of eta */
  /* Entries of the lower triangle of the linear-linear block, by column, diagonal first; returns 0 if it is diagonal.
   */
  int32_t (*linear_pattern)(const void* body, const int32_t** rows, const int32_t** columns);
  /* Markers: a frame at a position, at a node, at the mean of nodes; orientation: marker axes to body axes. They return
     its index, < 0: refused. May be null. */
  int32_t (*place_marker)(void* body, const double* position, const double* orientation, char* error, size_t size);
  int32_t (*node_marker)(void* body, int32_t node, const double* orientation, char* error, size_t size);
  int32_t (*average_marker)(void* body, const int32_t* nodes, int32_t count, const double* orientation, char* error,
                            size_t size);
  int32_t (*marker_count)(const void* body);
  int32_t (*initial_state)(const void* body, double* q, double* v, char* error, size_t error_size);
  void* (*create_cache)(const void* body, char* error, size_t error_size); /* one a thread and state; null: refused */
  void (*destroy_cache)(void* cache);
  /* Fills the cache; everything below is called after it. rotation: body axes to world axes, 9 numbers. */
  int32_t (*evaluate)(const void* body, const lithe_body_state*, int32_t level, double* rotation);
  /* r += M v_dot - f_v - f_internal - f_gravity */
  int32_t (*add_residual)(const void* body, const lithe_body_state*, const double* v_dot, const double* gravity,
                          double* r);
  int32_t (*add_tangent)(const void* body, const lithe_body_state*, const double* v_dot, const double* gravity,
                         const lithe_tangent_weights*, const lithe_body_tangent*);
  int32_t (*marker_kinematics)(const void* body, const lithe_body_state*, int32_t marker, int32_t level,
                               lithe_marker_kinematics*);
  int32_t (*energy)(const void* body, const lithe_body_state*, const double* gravity, lithe_body_energy*);
  /* Pairs of frames, first < second, that share a block of the tangent; returns how many. May be null: none. */
  int32_t (*frame_pairs)(const void* body, const int32_t** firsts, const int32_t** seconds);
} lithe_body_type;

/* ---- integrators ---- */

typedef struct lithe_body_slice {
  const char* name;
  int32_t frame, linear; /* q: 7 (if frame) + linear, v: 6 (if frame) + linear; bodies follow each other */
} lithe_body_slice;

typedef struct lithe_row_slice {
  const char* name;
  int32_t count;
} lithe_row_slice;

/* M(q) v_dot + G(q, t)ᵀ lambda = f(q, v, t),  g(q, t) = 0  (engine/motion/equations_of_motion.h). Everything after
   evaluate() refers to the state evaluated last. Functions return 0; otherwise end the step and return what they
   returned: the host knows why. */
typedef struct lithe_equations {
  size_t struct_size;
  void* host; /* first argument of the functions */
  int32_t q_count, v_count, row_count;
  int32_t body_count, row_slice_count, redundant_count, velocity_row_count;
  const lithe_body_slice* bodies;
  const lithe_row_slice* row_slices;
  const int32_t* redundant_rows; /* repeat others: solve() gives them no multiplier */
  const int32_t* velocity_rows;  /* on velocities alone: their g is 0 */
  int32_t reacts;                /* 1 if f depends on lambda (friction) */
  int32_t (*evaluate)(void* host, double time, const double* q, const double* v, int32_t level);
  int32_t (*residual)(void* host, const double* v_dot, const double* lambda, double* r);
  int32_t (*constraint)(void* host, int32_t which, double* out);
  int32_t (*factorize)(void* host, const lithe_tangent_weights*, const double* v_dot, const double* lambda,
                       const double* increment); /* increment may be null */
  int32_t (*solve)(void* host, double* rv, double* rl);
  int32_t (*visit_blocks)(void* host, void* visitor,
                          void (*visit)(void* visitor, int32_t row, int32_t column, int32_t rows, int32_t columns,
                                        const double* values, ptrdiff_t column_stride));
  int32_t (*retract)(void* host, const double* q, const double* d, double* out);       /* q ⊕ d */
  int32_t (*chart_rates)(void* host, const double* d, const double* v, double* d_dot); /* of the chart q_n ⊕ d */
  /* Whole turns of measured angles: the host recalls them before start and step, and tracks them after a step that
     reached; a method that goes further than half a turn within one calls these between. */
  int32_t (*recall)(void* host, const double* quarter_turns, int32_t count);
  int32_t (*track)(void* host, double* quarter_turns, int32_t count);
  /* The iteration matrix at complex weights, in a factor of its own; complex numbers are pairs of doubles. */
  int32_t (*factorize_complex)(void* host, const lithe_complex_tangent_weights*, const double* v_dot,
                               const double* lambda, const double* increment);
  int32_t (*solve_complex)(void* host, double* rv, double* rl);
  int32_t (*energy)(void* host, double* joules); /* kinetic, elastic, gravity: three numbers */
} lithe_equations;

typedef struct lithe_state {
  size_t struct_size;
  double time;
  double *q, *v, *v_dot, *lambda;
  double* quarter_turns; /* of measured angles */
  int32_t quarter_turn_count;
} lithe_state;

typedef struct lithe_statistics {
  size_t struct_size;
  int64_t steps, rejected, newton_iterations, factorizations, evaluations;
} lithe_statistics;

typedef struct lithe_integrator_type {
  size_t struct_size;
  const char* name;
  const lithe_field* fields;
  size_t field_count;
  void* (*create)(const lithe_parameter*, size_t count, char* error, size_t error_size);
  void (*destroy)(void* integrator);
  /* The equations stay valid until the next start() or destroy(). */
  int32_t (*start)(void* integrator, const lithe_equations*, lithe_state*, char* error, size_t error_size);
  /* One step, never past t_stop; > 0: it failed, the state is the last good one and `error` says why. */
  int32_t (*step)(void* integrator, lithe_state*, double t_stop, char* error, size_t error_size);
  void (*statistics)(const void* integrator, lithe_statistics*);
  /* For checkpoints; both may be null, or beyond the end of a shorter table: the host then starts the method anew
     wherever it saves, and where it resumes. save() writes what the next steps depend on besides the state and the
     parameters, at most `capacity` bytes, and returns how many there are; < 0: it cannot. load() takes it over after a
     start() with the equations and the state of then; 0, or else `error` says why not. Bytes of one machine: whoever
     writes them sees to their version. */
  int64_t (*save)(void* integrator, unsigned char* bytes, int64_t capacity);
  int32_t (*load)(void* integrator, const lithe_state*, const unsigned char* bytes, int64_t count, char* error,
                  size_t error_size);
} lithe_integrator_type;

/* ---- the entry ---- */

/* The functions take a type's table and return 0, or < 0 if the host refuses it; go on all the same. */
typedef struct lithe_host {
  size_t struct_size;
  void* context; /* first argument of the functions */
  int32_t (*add_joint)(void* context, const lithe_joint_type*);
  int32_t (*add_force)(void* context, const lithe_force_type*);
  int32_t (*add_body)(void* context, const lithe_body_type*);
  int32_t (*add_integrator)(void* context, const lithe_integrator_type*);
} lithe_host;

/* The one symbol of a plug-in library; returns 0, or < 0 if it will not serve this host. */
#ifdef __GNUC__
__attribute__((visibility("default")))
#endif
int32_t
lithe_plugin_v1(const lithe_host*);

#ifdef __cplusplus
}
#endif
