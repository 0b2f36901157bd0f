/* The C interface of environment plug-ins: an environment process in a shared library.
 *
 * A library exports one function, espalier_plugin_entry, that returns a table of functions. Espalier makes one instance
 * for every simulation and calls it from one thread at a time, which is not the program's first; instances of different
 * simulations are called at the same time. An instance that takes too long, throws (in C++) or answers with a number
 * that is not finite is given up: a new one gets the same configuration, is opened and gets the state that was saved
 * before the step, while the old one may still be in its call. Nothing of Espalier needs to be linked; C11 or C++ both
 * read this header.
 *
 *     espalier derive MODEL.l --environment ./libceiling.so
 *
 * Arrays belong to the caller and are valid during the call only. Texts are UTF-8 and end in a zero byte. A function
 * that can fail returns 0 on success; otherwise it writes a whole sentence that says what is wrong and what to do into
 * `message` (at most `message_size` bytes with the zero) and returns another number: the step fails, and the simulation
 * stays at its last completed step. Lengths are in the world's length unit (metres unless the simulation says
 * otherwise).
 */
#ifndef ESPALIER_ENVIRONMENT_PLUGIN_H
#define ESPALIER_ENVIRONMENT_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Rises when a table of this version can no longer be used. Members are only added at the end: `size` tells which are
 * there. */
#define ESPALIER_PLUGIN_VERSION 1u

/* Parts of a query that a process reads, summed in espalier_plugin.needs. Arrays that it does not need may be null. */
enum {
  ESPALIER_NEEDS_POSITION = 1,
  ESPALIER_NEEDS_HEADING = 2,
  ESPALIER_NEEDS_LEFT = 4,
  ESPALIER_NEEDS_UP = 8,
  ESPALIER_NEEDS_WIDTH = 16,
  ESPALIER_NEEDS_SCALE = 32,
  ESPALIER_NEEDS_FOLLOWING = 64,
  ESPALIER_NEEDS_GEOMETRY = 128 /* the shapes of all plants: asked in every step, also in one without queries */
};

/* No module follows the communication module. */
#define ESPALIER_NO_SYMBOL UINT16_MAX

/* A named value with its unit; the unit of a dimensionless value is "1". */
typedef struct espalier_variable {
  const char* name;
  const char* unit;
} espalier_variable;

/* The information that an instance gets when a simulation opens it. */
typedef struct espalier_context {
  uint64_t seed;
  uint32_t plant_count;
  uint32_t symbol_count;
  const char* const* symbols; /* names by number, for the queries' symbol and following (symbol_count) */
  const char* simulation;     /* identifier, for messages */
  const char* length_unit;
  double up[3];
  double north[3];
  double step_duration_days;
} espalier_context;

/* The origin of each row of a table of geometry, as arrays of `count` elements. */
typedef struct espalier_sources {
  size_t count;
  const uint32_t* plant;
  const uint64_t* module; /* index in the plant's string of the module that drew it */
  const uint16_t* symbol; /* of that module */
  const uint8_t* colour;  /* index of the colour or material */
  const uint32_t* branch_order;
} espalier_sources;

/* The kinds of an organ. */
enum { ESPALIER_CYLINDER = 0, ESPALIER_POLYGON = 1, ESPALIER_SURFACE = 2, ESPALIER_PATCH = 3, ESPALIER_BALL = 4 };

/* The shapes of all plants, in world coordinates: lines as round segments, everything else as organs of triangles, by
 * plant. The organ that a communication module stands before has the module index of its query plus one. */
typedef struct espalier_geometry {
  espalier_sources segments;
  const double* start; /* x, y, z (3 * segments.count); the same for the next */
  const double* end;
  const double* start_width; /* diameters (segments.count) */
  const double* end_width;
  uint32_t are_widths_pixels; /* not 0: the model draws lines of so many pixels, which have no size in the world */
  uint32_t reserved;
  espalier_sources organs;
  const uint8_t* kind;             /* ESPALIER_CYLINDER and so on (organs.count) */
  const uint64_t* vertex_offset;   /* (organs.count + 1): the vertices of organ i are those from offset i to i + 1 */
  const uint64_t* triangle_offset; /* (organs.count + 1) */
  const double* vertices;          /* x, y, z of all organs, concatenated */
  const uint32_t* triangles;       /* three indices of vertices each, of all organs, concatenated */
} espalier_geometry;

/* All communication modules of all plants in one step, in (plant, module) order, as arrays of `count` elements. */
typedef struct espalier_queries {
  uint64_t step;      /* completed steps when the queries were made */
  uint32_t iteration; /* 0 unless the coupling is iterated */
  uint32_t reserved;
  double time_days;
  size_t count;
  const uint32_t* plant;
  const uint64_t* module; /* index of the module in its plant's string */
  const uint16_t* symbol;
  const uint8_t* is_transient; /* made by a homomorphism: takes part, its reply is discarded; may be null: none is */
  const double* position;      /* x, y, z (3 * count); the same for the next three */
  const double* heading;
  const double* left;
  const double* up;
  const double* width;
  const double* scale;
  const uint64_t* parameter_offset; /* (count + 1): the parameters of query i are those from offset i to offset i + 1 */
  const double* parameters;
  const uint16_t* following;        /* symbol of the next module of the string, or ESPALIER_NO_SYMBOL */
  const uint64_t* following_offset; /* (count + 1) */
  const double* following_parameters;
  const espalier_geometry* geometry; /* null unless the process needs it */
} espalier_queries;

/* The answers, laid out as the parameters: value k of query i is at parameter_offset[i] + k. All is_set are 0 at first;
 * a value whose is_set stays 0 keeps what the module sent. Values must be finite. */
typedef struct espalier_replies {
  double* values;
  uint8_t* is_set;
} espalier_replies;

typedef struct espalier_plugin {
  uint32_t version; /* ESPALIER_PLUGIN_VERSION */
  uint32_t size;    /* sizeof(espalier_plugin) as the library was compiled */
  const char* name;
  const char* summary; /* one sentence */
  uint32_t needs;
  uint32_t is_stateful; /* not 0: it changes from step to step, and has save and restore */
  uint32_t input_count;
  uint32_t output_count;
  const espalier_variable* inputs;  /* parameters sent, in order (input_count) */
  const espalier_variable* outputs; /* parameters set, in order (output_count) */

  /* A new instance from its configuration (the text of a JSON object, "{}" for none), or null with a message. */
  void* (*create)(const char* configuration, char* message, size_t message_size);
  void (*destroy)(void* instance);
  /* Goes to the initial state; called before the first step and after every rewind. May be null. */
  int (*open)(void* instance, const espalier_context* context, char* message, size_t message_size);
  /* Answers all queries against the state left by the step before, then advances the state once. On failure the state
   * must be as before. */
  int (*step)(void* instance, const espalier_queries* queries, espalier_replies* replies, char* message,
              size_t message_size);
  /* A step of simulation time without queries. May be null. */
  int (*tick)(void* instance, uint64_t step, char* message, size_t message_size);
  /* Writes the complete state into `buffer` when `capacity` is enough; returns its size in bytes. Null unless
   * is_stateful. */
  size_t (*save)(void* instance, void* buffer, size_t capacity);
  int (*restore)(void* instance, const void* state, size_t state_size, char* message, size_t message_size);
} espalier_plugin;

/* The one function that a library exports; the table must live as long as the library. */
const espalier_plugin* espalier_plugin_entry(void);

#ifdef __cplusplus
}
#endif

#endif
