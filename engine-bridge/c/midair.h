#ifndef MIDAIR_H
#define MIDAIR_H 1

// NOLINTBEGIN(modernize-deprecated-headers,readability-identifier-naming): this is C.

/// \file
/// libmidair: mid-air haptics without a scene graph, in C99 and C++. It takes arrays, meshes or
/// points, returns activations, pressures and figures, and plays them on any device. C.md has an
/// example program and the rules.
///
/// Units: metres, seconds, pascals (peak) and hertz unless a name says otherwise. Positions are in
/// the array's frame, which is right-handed. Its origin depends on the array: for the octagon the
/// centre of its workspace, inside the prism; for "board" the middle of its own plane z = 0, from
/// which it emits towards +z, so that (0, 0, 0.15) is above it; for a file as its positions say.
///
/// Handles are opaque. A call with a closed handle, or with NULL, returns MIDAIR_CLOSED; the value
/// of a handle is never reused. Each handle has its own close function. Handles can be closed in
/// any order: a scene keeps its array, a field keeps all its data.
///
/// All functions may be called from any thread at any time unless documented otherwise. Calls with
/// the same scene or solver wait for each other only while arguments are copied; no call waits for
/// a solve of another thread, except for those of the same midair_solver. Fields and arrays are
/// immutable. The threads of callbacks are documented in midair_extend.h. C.md has a table of all
/// functions.
///
/// In the child of a fork() all scenes and solvers of the parent are closed, and nothing is written
/// to its devices. Fields and arrays stay valid; the child can make and solve new scenes (C.md).
///
/// Functions that can fail return a midair_status; midair_last_error() then returns a sentence. No
/// function throws C++ exceptions. On an error output arguments stay unchanged, except for counts
/// of the room needed and the fields of midair_solve_many(). A silent field is not an error, and
/// `status < 0` doesn't catch it: compare with MIDAIR_SILENT if silence is an error for you.

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define MIDAIR_API __attribute__((visibility("default"))) ///< symbols that the library exports
#else
#define MIDAIR_API ///< symbols that the library exports
#endif

#ifdef __cplusplus
extern "C"
{
#endif

// \{ Versions. A program that was built with one version runs with all later versions of the same
// major and minor number, which are in the library's soname.
#define MIDAIR_VERSION_MAJOR 0 ///< with the minor number: version of the interface
#define MIDAIR_VERSION_MINOR 1 ///< in the soname
#define MIDAIR_VERSION_PATCH 0 ///< version of the library
/// All three in one number.
#define MIDAIR_VERSION                                                                             \
    (MIDAIR_VERSION_MAJOR * 10000 + MIDAIR_VERSION_MINOR * 100 + MIDAIR_VERSION_PATCH)
    /// Returns the library's own MIDAIR_VERSION.
    MIDAIR_API uint32_t midair_version(void);
    // \}

    /// Result of a call: 0 and above means done, below 0 means not done.
    typedef int32_t midair_status;
    enum
    {
        MIDAIR_OK = 0,
        /// done, but the field is silent (all activations are 0): nothing is wanted, or a cap, the
        /// reach of hands or the array's levels leave nothing of it; midair_last_error() gives the
        /// reason. Returned only by midair_solve(), midair_solver_solve(), midair_newest_field()
        /// and midair_field_from_bytes()
        MIDAIR_SILENT = 1,
        MIDAIR_INVALID = -1,   ///< an argument is null, not finite, of a wrong size or out of range
        MIDAIR_CLOSED = -2,    ///< the handle is closed or NULL
        MIDAIR_UNKNOWN = -3,   ///< no item has this name, index or number
        MIDAIR_REFUSED = -4,   ///< can't be read, opened or solved
        MIDAIR_TOO_SMALL = -5, ///< the caller's memory is too small; the count says what is needed
        MIDAIR_NOT_YET = -6,   ///< not available yet
        MIDAIR_STOPPED = -7,   ///< stopped by midair_cancel()
        MIDAIR_SILENCED = -8,  ///< a value that concerns safety is invalid: nothing is played
        MIDAIR_NO_MEMORY = -9,
        MIDAIR_FAILED = -10 ///< a program's solver found no field, or the library failed
    };
    /// Returns "ok", "invalid" and so on; "unknown status" for other numbers.
    MIDAIR_API const char* midair_status_name(midair_status status);
    /// Returns a sentence that says why this thread's last call failed or gave silence, otherwise
    /// "". Valid until this thread's next call.
    MIDAIR_API const char* midair_last_error(void);

    typedef struct midair_array midair_array; ///< transducers
    typedef struct midair_scene midair_scene; ///< objects, settings, hands and the device
    typedef struct midair_field midair_field; ///< a solved or played field; immutable
    typedef struct midair_solver
        midair_solver;              ///< solves sets of points, each starting from the last field
    typedef uint64_t midair_object; ///< number of an object of a scene; never 0, never reused

    // --- Arrays ----------------------------------------------------------------------------------

    /// One transducer of an array.
    typedef struct midair_transducer
    {
        double position[3];      ///< m, -10 .. 10
        double normal[3];        ///< direction of emission, any length but 0
        double phase_offset_rad; ///< -1000 .. 1000; added to its drive
        double gain;             ///< 0 .. 1000; factor on its amplitude
        int32_t board;           ///< counts up from 0 without a gap
        int32_t dead;            ///< 0 or 1; 1: it is never driven
    } midair_transducer;

    /// Loads "octagon", "board", a shipped array by its name, or a JSON file by its path. While a
    /// scene plays on it, a changed file is read again and used for all later fields. The origin of
    /// the octagon is the centre of its workspace, that of "board" the middle of its plane.
    MIDAIR_API midair_status midair_array_load(const char* name_or_file, midair_array** array);
    /// Loads an array from JSON text (samples/guides/ARRAYS.md).
    MIDAIR_API midair_status midair_array_from_json(const char* json, midair_array** array);
    /// Makes an array of 1 .. 65536 transducers with the directivity and ringing of a T4010A1's
    /// data sheet. \a frequency_Hz: up to 1e7; \a source_Pa_m: peak pressure times distance on the
    /// axis at full drive, up to 1e5. The level at ears is computed with at least the data sheet's
    /// 10.1.
    MIDAIR_API midair_status midair_array_make(const char* name,
                                               const midair_transducer* transducers,
                                               size_t count,
                                               double frequency_Hz,
                                               double source_Pa_m,
                                               midair_array** array);
    /// Returns the number of transducers.
    MIDAIR_API midair_status midair_array_size(const midair_array* array, size_t* transducers);
    /// Copies all transducers; \a capacity: room in \a transducers.
    MIDAIR_API midair_status midair_array_transducers(const midair_array* array,
                                                      midair_transducer* transducers,
                                                      size_t capacity);
    /// Closes the handle; scenes that use the array keep it.
    MIDAIR_API midair_status midair_array_close(midair_array* array);

    // --- Scenes and their objects ----------------------------------------------------------------

    /// Makes a scene with the default settings and no objects.
    MIDAIR_API midair_status midair_scene_make(midair_array* array, midair_scene** scene);
    /// Stops playing (which silences the device), aborts running solves, and frees the scene.
    MIDAIR_API midair_status midair_scene_close(midair_scene* scene);

    /// Sets a setting by its name in scene files: ("maxPressure", "800 Pa"), ("cycle", "4"),
    /// ("temperature", "24"). A value that can't be parsed or is out of range is an error and
    /// changes nothing. If it concerns safety (caps, enabled, dead, weak, loudness, reach, ears),
    /// nothing is played until this setting, or the one whose name was mistyped, is set to a valid
    /// value.
    MIDAIR_API midair_status midair_set(midair_scene* scene, const char* name, const char* value);
    /// Writes the value of a setting as text with its terminator into \a text; \a size: room in \a
    /// text, or 0. \a needed (may be NULL): room that the text takes.
    MIDAIR_API midair_status
    midair_get(midair_scene* scene, const char* name, char* text, size_t size, size_t* needed);

    /// Adds a mesh: \a vertices has x, y, z per vertex, \a triangles three indices per triangle. A
    /// triangle (a, b, b) is a line, (a, a, a) a point. \a intensity, 0 .. 1 per vertex, scales the
    /// pressure; NULL: 1. All data is copied. The pose is the identity, and the properties have
    /// their defaults.
    MIDAIR_API midair_status midair_add_mesh(midair_scene* scene,
                                             const double* vertices,
                                             size_t vertex_count,
                                             const uint32_t* triangles,
                                             size_t triangle_count,
                                             const float* intensity,
                                             midair_object* object);
    /// Adds the mesh of a Wavefront OBJ file. \a size_m: the mesh is scaled to this largest extent
    /// and its centre moved to the origin; 0: as in the file. midair_messages() lists the parts of
    /// the file that can't be rendered.
    MIDAIR_API midair_status midair_add_file(midair_scene* scene,
                                             const char* obj_file,
                                             double size_m,
                                             midair_object* object);
    /// Adds control points that are solved without sampling: \a positions has x, y, z per point; \a
    /// pressures one value per point, 0 or 1e-6 .. 1e5, in Pa if \a in_pascal, otherwise relative
    /// to each other; NULL: 1, relative. Their property "pressure" can't be set.
    MIDAIR_API midair_status midair_add_points(midair_scene* scene,
                                               const double* positions,
                                               const double* pressures,
                                               size_t count,
                                               int32_t in_pascal,
                                               midair_object* object);
    /// Adds a sensation without a mesh: the property "sensation" is \a sensation, a classic with
    /// parameters ("circle?radius=20mm"), the path of an .adaptics file, or such a file's text. It
    /// plays at the object's pose; the properties "attach", "trigger", "parameters", "pressure",
    /// .. say where, when and how (midair_sensations() in midair_play.h lists what plays).
    /// MIDAIR_REFUSED: it can't be read.
    MIDAIR_API midair_status midair_add_sensation(midair_scene* scene,
                                                  const char* sensation,
                                                  midair_object* object);
    /// Replaces the vertices of a mesh or the positions of points; their number must stay the same.
    MIDAIR_API midair_status midair_move_vertices(midair_scene* scene,
                                                  midair_object object,
                                                  const double* vertices,
                                                  size_t vertex_count);
    /// Sets the pose of an object: \a matrix is 4 x 4, row by row, for column vectors (place =
    /// matrix * vertex), a rotation and a translation without scale.
    MIDAIR_API midair_status midair_set_pose(midair_scene* scene,
                                             midair_object object,
                                             const double matrix[16]);
    /// Sets a haptic property of an object by its name in scene files: ("pressure", "500 Pa"),
    /// ("sampling", "edges"), ("render", "contact"). Errors: see midair_set().
    MIDAIR_API midair_status midair_object_set(midair_scene* scene,
                                               midair_object object,
                                               const char* name,
                                               const char* value);
    /// Gets a haptic property of an object; see midair_get().
    MIDAIR_API midair_status midair_object_get(midair_scene* scene,
                                               midair_object object,
                                               const char* name,
                                               char* text,
                                               size_t size,
                                               size_t* needed);
    /// Removes an object; its number is never reused.
    MIDAIR_API midair_status midair_remove(midair_scene* scene, midair_object object);

    /// Lists the settings of midair_set(), or of midair_object_set() if \a of_objects, by index
    /// from 0. \a summary is one line with help, values and default. \a name and \a summary may be
    /// NULL; both stay valid for the whole program. MIDAIR_UNKNOWN after the last one.
    MIDAIR_API midair_status midair_setting(int32_t of_objects,
                                            size_t index,
                                            const char** name,
                                            const char** summary);

    // --- Solving ---------------------------------------------------------------------------------

    /// Solves the present scene once, like midair-solve: the same input gives the same drives (with
    /// maxPoints 0: up to 2000 points). Returns when it is done; MIDAIR_SILENT also gives a field.
    /// MIDAIR_FAILED: a solver of the program failed, threw, or found no activations of at most 1;
    /// MIDAIR_REFUSED: the scene can't be solved. All caps apply. Runs on this thread and on the
    /// scene's "threads"; any number of calls can run at a time.
    MIDAIR_API midair_status midair_solve(midair_scene* scene, midair_field** field);
    /// Aborts all running solves of the scene: they return MIDAIR_STOPPED within milliseconds.
    MIDAIR_API midair_status midair_cancel(midair_scene* scene);

    /// Opens a solver with the scene's present array and settings. It solves one set of points
    /// after another, each starting from the last field. A solver doesn't apply caps: it is refused
    /// while the scene has one, or plays fields in turn, outlines at rest otherwise or a monitor.
    /// Points that move by less than motionTolerance keep the last field.
    MIDAIR_API midair_status midair_solver_open(midair_scene* scene, midair_solver** solver);
    /// Solves for \a count points: \a positions has x, y, z per point, \a targets one value >= 0
    /// per point (Pa if \a in_pascal, otherwise ratios). \a activations: real and imaginary part
    /// for each of \a transducers, the array's number; 1 is full drive, rounded to the array's
    /// levels. Calls of one solver wait for each other. MIDAIR_SILENT: all are 0. Errors: see
    /// midair_solve().
    MIDAIR_API midair_status midair_solver_solve(midair_solver* solver,
                                                 const double* positions,
                                                 const double* targets,
                                                 size_t count,
                                                 int32_t in_pascal,
                                                 float* activations,
                                                 size_t transducers);
    /// Aborts a running solve: it returns MIDAIR_STOPPED, and the next one starts without a field.
    MIDAIR_API midair_status midair_solver_cancel(midair_solver* solver);
    /// Gets a figure of the last midair_solver_solve(); see midair_field_figure().
    MIDAIR_API midair_status midair_solver_figure(midair_solver* solver,
                                                  const char* name,
                                                  double* value);
    /// Closes the handle, after waiting for a running solve.
    MIDAIR_API midair_status midair_solver_close(midair_solver* solver);

    /// Input of midair_solve_many(): K fields of n points each.
    typedef struct midair_many
    {
        size_t struct_size;      ///< sizeof(midair_many)
        size_t fields;           ///< K, 1 .. 1e9
        size_t points;           ///< n, 1 .. 1000
        const double* positions; ///< K x n x 3, m: x, y, z of each point of each field
        /// ratios of the wanted pressures, >= 0, not all 0 in a field: K x n, or n if same_targets;
        /// NULL: all equal. A point of target 0 is held silent, so fades end continuously.
        const double* targets;
        int32_t same_targets; ///< 1: the targets of the first field hold for all
        int32_t reserved;     ///< 0
        /// length of a path of successive fields, each of which starts from the one before; paths
        /// run on the scene's "threads". 0: all fields are one path, on one thread; 1: no field
        /// depends on another
        size_t fields_in_path;
        double tolerance; ///< rms error that is good enough, 3e-4 .. 0.3; 0: 0.01
        /// largest change of a phase from one field of a path to the next, rad, at least four of
        /// the array's phases (at most pi); 0: no bound
        double largest_phase_step_rad;
        uint64_t seed; ///< of starting phases; equal seeds give equal fields
    } midair_many;
    /// Layout of the phases of midair_solve_many().
    typedef struct midair_many_layout
    {
        uint32_t transducers;  ///< m
        uint32_t phase_levels; ///< P, 2 .. 256: level L means e^{+j 2 pi L/P}
    } midair_many_layout;
    /// Figures of a field of midair_solve_many(), measured after rounding.
    typedef struct midair_many_figures
    {
        /// relative rms error of the pressures; for targets below 0.3 of the largest relative to
        /// more than the target
        float rms;
        float level_Pa;       ///< pressure of the largest target, peak Pa at full drive
        float loudness;       ///< 1: the energy of one focus, shared by all points
        float phase_step_rad; ///< largest change of a phase since the last field of the path
    } midair_many_figures;
    /// Solves for many fields, thousands a second, with the scene's array, "dead", "weak", air and
    /// "threads". It applies no caps and plays nothing: it is refused while the scene has a cap or
    /// another setting that it doesn't use. \a phases: K x m levels, at full amplitude, 0 for dead
    /// transducers; \a size: room there, or 0, which only queries. \a layout (may be NULL) is set
    /// then, too. \a figures: K, or NULL if they aren't wanted, which saves time. Returns when it
    /// is done; midair_cancel() aborts it. MIDAIR_REFUSED: a point is out of the array's reach, or
    /// a setting isn't used. After that and MIDAIR_STOPPED phases and figures are partly written.
    MIDAIR_API midair_status midair_solve_many(midair_scene* scene,
                                               const midair_many* many,
                                               uint8_t* phases,
                                               size_t size,
                                               midair_many_layout* layout,
                                               midair_many_figures* figures);

    // --- Fields ----------------------------------------------------------------------------------

    /// Properties of a field.
    typedef struct midair_field_info
    {
        uint64_t frame;       ///< number of its midair_update(); 0: from midair_solve()
        uint32_t transducers; ///< m
        uint32_t fields;      ///< number of fields played in turn; 1: one is held
        uint32_t points;      ///< n, of all fields together
        int32_t playing;      ///< 1: an open device has taken it, and it is not silence
        double rate_Hz;       ///< rate of fields in turn; 0: one is held
        double latency_ms;    ///< from midair_update() to the device; 0 for midair_solve()
    } midair_field_info;

    /// A control point of a field.
    typedef struct midair_point
    {
        double position[3];   ///< array frame
        double normal[3];     ///< of length 1, out of the object; zero if it has none
        double wanted_Pa;     ///< relative targets: at the level of this field
        double achieved_Pa;   ///< in its field as played; with evened cycles: as felt
        midair_object object; ///< 0 if it was removed
        uint32_t field;       ///< index of its field in turn
        uint32_t reserved;    ///< 0
    } midair_point;

    /// Gets the properties of the field.
    MIDAIR_API midair_status midair_field_about(const midair_field* field, midair_field_info* info);
    /// Copies the activations of field \a index in turn, as played: real and imaginary part for
    /// each of \a transducers, the field's number.
    MIDAIR_API midair_status midair_field_activations(const midair_field* field,
                                                      size_t index,
                                                      float* activations,
                                                      size_t transducers);
    /// Gets the same activations without a copy; they stay valid and unchanged until the field is
    /// closed.
    MIDAIR_API midair_status midair_field_view(const midair_field* field,
                                               size_t index,
                                               const float** activations);
    /// Gets the same drives as levels of the array. A phase level L of P means e^{+j 2 pi L/P}; \a
    /// amplitudes are indices into the array's amplitudes (256 by default, sin(pi L/510)), or -1
    /// for off where these have no 0. They are the last two columns of midair-solve's drive.csv.
    MIDAIR_API midair_status midair_field_levels(const midair_field* field,
                                                 size_t index,
                                                 int32_t* phases,
                                                 int32_t* amplitudes,
                                                 size_t transducers);
    /// Writes field \a index as midair-solve's drive.csv: one line per transducer with its
    /// position, its normal and these two levels. An existing file is replaced.
    MIDAIR_API midair_status midair_field_write_drive(const midair_field* field,
                                                      size_t index,
                                                      const char* file);
    /// Copies the control points; \a capacity: room in \a points.
    MIDAIR_API midair_status midair_field_points(const midair_field* field,
                                                 midair_point* points,
                                                 size_t capacity);
    /// Gets a figure by its name in midair-solve's summary.json: "rms", "level_Pa", "loudness",
    /// "exposure.level_dB" and so on; "fingertipForce_N" is the force on a fingertip at the
    /// strongest place.
    MIDAIR_API midair_status midair_field_figure(const midair_field* field,
                                                 const char* name,
                                                 double* value);
    /// Lists the figures by index from 0; \a name is valid until the field is closed.
    /// MIDAIR_UNKNOWN after the last one.
    MIDAIR_API midair_status midair_field_figure_at(const midair_field* field,
                                                    size_t index,
                                                    const char** name,
                                                    double* value);
    /// Gets a text: "solver", "stop" (why the solver stopped), "message" (for people), or
    /// "feeling": how most people perceive fingertipForce_N, "too weak to feel", "faint", "clear"
    /// or "strong". See midair_get().
    MIDAIR_API midair_status midair_field_text(
        const midair_field* field, const char* name, char* text, size_t size, size_t* needed);
    /// Computes the complex peak pressure of field \a index in turn, real and imaginary part, at \a
    /// count places (x, y, z of each), within 1e-5 of the maximum of all transducers together.
    MIDAIR_API midair_status midair_field_pressures(const midair_field* field,
                                                    size_t index,
                                                    const double* places,
                                                    size_t count,
                                                    float* pressures);
    /// Computes the felt pressure: the root of the mean of |p|^2 over all fields in turn, Pa.
    MIDAIR_API midair_status midair_field_felt(const midair_field* field,
                                               const double* places,
                                               size_t count,
                                               float* pressures);
    /// Serializes the field; midair_field_from_bytes() makes an equal one of the bytes, also in
    /// another process or later, with the same major and minor version on a like machine. \a size:
    /// room in \a bytes, or 0. \a needed (may be NULL): room that the bytes take.
    MIDAIR_API midair_status midair_field_bytes(const midair_field* field,
                                                void* bytes,
                                                size_t size,
                                                size_t* needed);
    /// Makes a field from the bytes of midair_field_bytes(). MIDAIR_REFUSED: they are not a field;
    /// MIDAIR_SILENT: the field is silence.
    MIDAIR_API midair_status midair_field_from_bytes(const void* bytes,
                                                     size_t size,
                                                     midair_field** field);
    /// Closes the handle and frees the field.
    MIDAIR_API midair_status midair_field_close(midair_field* field);

#ifdef __cplusplus
}
#endif

#include "midair_extend.h"
#include "midair_play.h"

// NOLINTEND(modernize-deprecated-headers,readability-identifier-naming)
#endif
