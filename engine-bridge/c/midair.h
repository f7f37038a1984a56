#ifndef MIDAIR_H
#define MIDAIR_H 1

// NOLINTBEGIN(modernize-deprecated-headers,readability-identifier-naming): this is C.

/// \file
/// libmidair: mid-air haptics without a scene graph, in C99 and C++. Arrays, meshes or points in;
/// activations, pressures and figures out; played on any device. C.md has a program and the rules.
///
/// Units: metres, seconds, pascals (peak) and hertz unless a name says otherwise. Places are in the
/// array's frame, which is right-handed. Each array puts its origin where it wants it: the octagon
/// at the centre of its workspace, inside the prism; "board" in the middle of its own plane z = 0,
/// from which it emits towards +z, so that (0, 0, 0.15) is over it; a file where its positions say.
///
/// Handles are opaque. A call with one that was closed, or is NULL, returns MIDAIR_CLOSED; a handle
/// is never given twice. Each closes with its own function, in any order: a scene keeps the array
/// that it was made with, a field all that it needs.
///
/// Every function may be called from any thread, at any time, unless it says otherwise here. Calls
/// with one scene or solver wait for each other for as long as it takes to copy what they are
/// given; no call waits for a solve of another thread, but for those of one midair_solver. Fields
/// and arrays never change. Callbacks (midair_extend.h) say on which threads they run. C.md has a
/// table with each function.
///
/// In the child of a fork() all scenes and solvers of the parent are closed, and its devices are
/// not written to; fields and arrays stay, scenes can be solved, and new ones be made (C.md).
///
/// Every function that can fail returns a midair_status; midair_last_error() then has a sentence.
/// No C++ exception leaves a function, and what a function returns with an error it leaves
/// untouched, but for a count that says how much room there must be. A field that is silence is no
/// error, and `status < 0` doesn't see it: compare with MIDAIR_SILENT where silence is one to you.

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define MIDAIR_API __attribute__((visibility("default"))) ///< what the library exports
#else
#define MIDAIR_API ///< what the library exports
#endif

#ifdef __cplusplus
extern "C"
{
#endif

// \{ Versions. A program that was built with one runs with all later ones of the same major and
// minor number, which are in the library's soname.
#define MIDAIR_VERSION_MAJOR 0 ///< with the minor number the interface's
#define MIDAIR_VERSION_MINOR 1 ///< in the soname
#define MIDAIR_VERSION_PATCH 0 ///< of the library
/// The three as one number.
#define MIDAIR_VERSION                                                                             \
    (MIDAIR_VERSION_MAJOR * 10000 + MIDAIR_VERSION_MINOR * 100 + MIDAIR_VERSION_PATCH)
    /// Returns the library's own MIDAIR_VERSION.
    MIDAIR_API uint32_t midair_version(void);
    // \}

    /// What became of a call: 0 and above it was done, below it was not.
    typedef int32_t midair_status;
    enum
    {
        MIDAIR_OK = 0,
        /// done, and nothing sounds: nothing is wanted, or a cap, the reach of hands or the levels
        /// of the array leave nothing of it; midair_last_error() says which. There is a field, all
        /// of whose activations are 0. Of midair_solve(), midair_solver_solve(),
        /// midair_newest_field() and midair_field_from_bytes() alone
        MIDAIR_SILENT = 1,
        MIDAIR_INVALID = -1,   ///< an argument: null, not finite, of a wrong size or out of range
        MIDAIR_CLOSED = -2,    ///< a handle that is closed, or NULL
        MIDAIR_UNKNOWN = -3,   ///< there is nothing of that name, index or number
        MIDAIR_REFUSED = -4,   ///< it can't be read, opened or solved
        MIDAIR_TOO_SMALL = -5, ///< the caller's memory; the count says what is needed
        MIDAIR_NOT_YET = -6,   ///< there is none so far
        MIDAIR_STOPPED = -7,   ///< by midair_cancel()
        MIDAIR_SILENCED = -8, ///< a value that concerns safety wasn't understood: nothing is played
        MIDAIR_NO_MEMORY = -9,
        MIDAIR_FAILED = -10 ///< a solver of the program's found no field; or a fault of the library
    };
    /// Returns "ok", "invalid" and so on; "unknown status" for other numbers.
    MIDAIR_API const char* midair_status_name(midair_status status);
    /// Returns why the last call of this thread failed or gave silence, a sentence; "" if it did
    /// neither. Valid until this thread's next call.
    MIDAIR_API const char* midair_last_error(void);

    typedef struct midair_array midair_array; ///< transducers
    typedef struct midair_scene
        midair_scene; ///< objects, settings, hands, and the device they play on
    typedef struct midair_field midair_field; ///< what was solved or is played; immutable
    typedef struct midair_solver
        midair_solver;              ///< solves point after point, each from the last field
    typedef uint64_t midair_object; ///< number of an object of a scene; never 0, nor given twice

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

    /// Loads "octagon", "board", the name of a shipped array, or a JSON file of that path. While a
    /// scene plays on it, a file that has changed is read again, for its fields from then on. The
    /// octagon's origin is the centre of its workspace, that of "board" the middle of its plane.
    MIDAIR_API midair_status midair_array_load(const char* name_or_file, midair_array** array);
    /// Reads the text of such a file (samples/guides/ARRAYS.md).
    MIDAIR_API midair_status midair_array_from_json(const char* json, midair_array** array);
    /// Makes one of 1 .. 65536 transducers, with the data sheet's directivity and ringing of a
    /// T4010A1. \a frequency_Hz: up to 1e7; \a source_Pa_m: peak pressure times distance on the
    /// axis at full drive, up to 1e5; for the level at ears at least the data sheet's 10.1 counts.
    MIDAIR_API midair_status midair_array_make(const char* name,
                                               const midair_transducer* transducers,
                                               size_t count,
                                               double frequency_Hz,
                                               double source_Pa_m,
                                               midair_array** array);
    /// Number of transducers.
    MIDAIR_API midair_status midair_array_size(const midair_array* array, size_t* transducers);
    /// Copies all transducers; \a capacity: how many there is room for.
    MIDAIR_API midair_status midair_array_transducers(const midair_array* array,
                                                      midair_transducer* transducers,
                                                      size_t capacity);
    /// Closes the handle; scenes keep what they were made with.
    MIDAIR_API midair_status midair_array_close(midair_array* array);

    // --- Scenes and their objects ----------------------------------------------------------------

    /// Makes a scene without objects, with the default settings.
    MIDAIR_API midair_status midair_scene_make(midair_array* array, midair_scene** scene);
    /// Stops playing, which silences the device, breaks off solves, and forgets the scene.
    MIDAIR_API midair_status midair_scene_close(midair_scene* scene);

    /// Sets a setting of scene files by its name there: ("maxPressure", "800 Pa"), ("cycle", "4"),
    /// ("temperature", "24"). A value that isn't understood, or is out of its range, is an error
    /// and changes nothing; but if it concerns safety (caps, enabled, dead, weak, loudness,
    /// reach, ears) nothing is played until that setting, or the one it may have been meant for, is
    /// set to a right value.
    MIDAIR_API midair_status midair_set(midair_scene* scene, const char* name, const char* value);
    /// Writes a setting as text, with an end, into \a text; \a size: its room, or 0. \a needed,
    /// which may be NULL: the room that it takes.
    MIDAIR_API midair_status
    midair_get(midair_scene* scene, const char* name, char* text, size_t size, size_t* needed);

    /// Adds a mesh: \a vertices x, y, z of each, \a triangles three indices of each. A triangle (a,
    /// b, b) is a line, (a, a, a) a point. \a intensity, 0 .. 1 of each vertex, is a factor on the
    /// pressure; NULL: 1. All are copied. The pose is the identity, and the properties are the
    /// defaults.
    MIDAIR_API midair_status midair_add_mesh(midair_scene* scene,
                                             const double* vertices,
                                             size_t vertex_count,
                                             const uint32_t* triangles,
                                             size_t triangle_count,
                                             const float* intensity,
                                             midair_object* object);
    /// Adds the mesh of a Wavefront OBJ file. \a size_m: its largest extent, and its centre goes to
    /// the origin; 0: as in the file. What of the file can't be felt as it was meant is among the
    /// midair_messages().
    MIDAIR_API midair_status midair_add_file(midair_scene* scene,
                                             const char* obj_file,
                                             double size_m,
                                             midair_object* object);
    /// Adds points that are solved for as they are: \a positions x, y, z of each; \a pressures of
    /// each, 0 or 1e-6 .. 1e5, in Pa if \a in_pascal, else relative to each other; NULL: 1,
    /// relative. Their property "pressure" can't be set.
    MIDAIR_API midair_status midair_add_points(midair_scene* scene,
                                               const double* positions,
                                               const double* pressures,
                                               size_t count,
                                               int32_t in_pascal,
                                               midair_object* object);
    /// Replaces the vertices of a mesh, or the places of points, of which there have to be as many.
    MIDAIR_API midair_status midair_move_vertices(midair_scene* scene,
                                                  midair_object object,
                                                  const double* vertices,
                                                  size_t vertex_count);
    /// Sets where an object is: \a matrix is 4 x 4, row by row, for columns (place = matrix *
    /// vertex), a rotation and a translation without scale.
    MIDAIR_API midair_status midair_set_pose(midair_scene* scene,
                                             midair_object object,
                                             const double matrix[16]);
    /// Sets a property of haptic objects by its name in scene files: ("pressure", "500 Pa"),
    /// ("sampling", "edges"), ("render", "contact"). Errors as of midair_set().
    MIDAIR_API midair_status midair_object_set(midair_scene* scene,
                                               midair_object object,
                                               const char* name,
                                               const char* value);
    /// As midair_get().
    MIDAIR_API midair_status midair_object_get(midair_scene* scene,
                                               midair_object object,
                                               const char* name,
                                               char* text,
                                               size_t size,
                                               size_t* needed);
    /// Removes an object; its number is never given again.
    MIDAIR_API midair_status midair_remove(midair_scene* scene, midair_object object);

    /// Names what midair_set() knows, or midair_object_set() if \a of_objects, by their number from
    /// 0: \a name, and \a summary, help with values and default in one line; either may be NULL.
    /// They are valid for the whole program. MIDAIR_UNKNOWN behind the last one.
    MIDAIR_API midair_status midair_setting(int32_t of_objects,
                                            size_t index,
                                            const char** name,
                                            const char** summary);

    // --- Solving ---------------------------------------------------------------------------------

    /// Solves the scene as it is once, as midair-solve does: the same drives for the same input
    /// (with maxPoints 0 up to 2000 points). Returns when it is done; MIDAIR_SILENT gives a field
    /// as well. MIDAIR_FAILED: a solver of the program's has failed or thrown, or found no
    /// activations of at most 1; MIDAIR_REFUSED: what is asked for can't be solved. All caps hold.
    /// Runs on this thread, and on the scene's "threads"; any number at a time.
    MIDAIR_API midair_status midair_solve(midair_scene* scene, midair_field** field);
    /// Breaks off all solves of the scene that run now: they return MIDAIR_STOPPED within
    /// milliseconds.
    MIDAIR_API midair_status midair_cancel(midair_scene* scene);

    /// Opens a solver with the array and the settings that the scene has now, for one set of points
    /// after the other, which begins with the field of the last one. It keeps no caps: it is
    /// refused while the scene has one, or plays fields in turn, outlines at rest otherwise or a
    /// monitor. Points that move by less than motionTolerance keep the last field.
    MIDAIR_API midair_status midair_solver_open(midair_scene* scene, midair_solver** solver);
    /// Solves for \a count points, \a positions x, y, z of each, and their \a targets (>= 0; Pa if
    /// \a in_pascal, else their ratios). \a activations: real and imaginary part for each of
    /// \a transducers, the array's number; 1 is full drive, rounded to the array's levels. One call
    /// of a solver waits for the other. MIDAIR_SILENT: they are all 0. Errors as of midair_solve().
    MIDAIR_API midair_status midair_solver_solve(midair_solver* solver,
                                                 const double* positions,
                                                 const double* targets,
                                                 size_t count,
                                                 int32_t in_pascal,
                                                 float* activations,
                                                 size_t transducers);
    /// Breaks off the solve that runs now, if there is one: it returns MIDAIR_STOPPED, and the next
    /// one starts from nothing.
    MIDAIR_API midair_status midair_solver_cancel(midair_solver* solver);
    /// A figure, as of midair_field_figure(), of the last midair_solver_solve().
    MIDAIR_API midair_status midair_solver_figure(midair_solver* solver,
                                                  const char* name,
                                                  double* value);
    /// Closes the handle, after a solve that runs.
    MIDAIR_API midair_status midair_solver_close(midair_solver* solver);

    // --- Fields ----------------------------------------------------------------------------------

    /// What a field is.
    typedef struct midair_field_info
    {
        uint64_t frame; ///< number of the midair_update() that it is for; 0: of midair_solve()
        uint32_t transducers; ///< m
        uint32_t fields;      ///< that are played in turn; 1: one is held
        uint32_t points;      ///< n, all fields' together
        int32_t playing;      ///< 1: a device is open, has taken it, and it is not silence
        double rate_Hz;       ///< at which fields in turn follow each other; 0: one is held
        double latency_ms;    ///< from midair_update() to the device; of midair_solve() 0
    } midair_field_info;

    /// A control point of a field.
    typedef struct midair_point
    {
        double position[3]; ///< array frame
        double normal[3];   ///< of length 1, out of the object; zero: it has none
        double wanted_Pa;   ///< relative ones: at the level that the field has
        double
            achieved_Pa; ///< in the field that is for it, as it is played; evened cycles: as felt
        midair_object object; ///< 0: it was removed
        uint32_t field;       ///< which of the fields in turn is for it
        uint32_t reserved;    ///< 0
    } midair_point;

    /// What the field is, in numbers.
    MIDAIR_API midair_status midair_field_about(const midair_field* field, midair_field_info* info);
    /// Copies activations of field \a index in turn, as they are played: real and imaginary part
    /// for each of \a transducers, the field's number.
    MIDAIR_API midair_status midair_field_activations(const midair_field* field,
                                                      size_t index,
                                                      float* activations,
                                                      size_t transducers);
    /// The same without a copy: \a activations is valid, and stays as it is, until the field is
    /// closed.
    MIDAIR_API midair_status midair_field_view(const midair_field* field,
                                               size_t index,
                                               const float** activations);
    /// The same as levels of the array: \a phases L of P means e^{+j 2 pi L/P}; \a amplitudes are
    /// indices into the array's amplitudes, for 256 of them sin(pi L/510), and -1 for off where
    /// these have no 0. They are the last two columns of midair-solve's drive.csv.
    MIDAIR_API midair_status midair_field_levels(const midair_field* field,
                                                 size_t index,
                                                 int32_t* phases,
                                                 int32_t* amplitudes,
                                                 size_t transducers);
    /// Writes field \a index as midair-solve's drive.csv: a line for each transducer with its
    /// place, its
    /// normal and these two levels. A file that is there is replaced.
    MIDAIR_API midair_status midair_field_write_drive(const midair_field* field,
                                                      size_t index,
                                                      const char* file);
    /// Copies its control points; \a capacity: how many there is room for.
    MIDAIR_API midair_status midair_field_points(const midair_field* field,
                                                 midair_point* points,
                                                 size_t capacity);
    /// A figure by its name in midair-solve's summary.json: "rms", "level_Pa", "loudness",
    /// "exposure.level_dB" and so on
    MIDAIR_API midair_status midair_field_figure(const midair_field* field,
                                                 const char* name,
                                                 double* value);
    /// Names the figures by their number from 0; \a name is valid until the field is closed.
    /// MIDAIR_UNKNOWN behind the last one.
    MIDAIR_API midair_status midair_field_figure_at(const midair_field* field,
                                                    size_t index,
                                                    const char** name,
                                                    double* value);
    /// What the solver, the reason for its end and the message for people are: "solver", "stop" or
    /// "message". As midair_get().
    MIDAIR_API midair_status midair_field_text(
        const midair_field* field, const char* name, char* text, size_t size, size_t* needed);
    /// Complex peak pressure of field \a index in turn, real and imaginary part, at \a count places
    /// (x, y, z of each), within 1e-5 of what all transducers together can do.
    MIDAIR_API midair_status midair_field_pressures(const midair_field* field,
                                                    size_t index,
                                                    const double* places,
                                                    size_t count,
                                                    float* pressures);
    /// What is felt: the root of the mean of |p|^2 over all fields in turn, Pa.
    MIDAIR_API midair_status midair_field_felt(const midair_field* field,
                                               const double* places,
                                               size_t count,
                                               float* pressures);
    /// Writes all of the field as bytes, of which midair_field_from_bytes() makes an equal one: in
    /// another process, or later, of the same major and minor version on a like machine. \a size:
    /// the room in \a bytes, or 0. \a needed, which may be NULL: the room that it takes.
    MIDAIR_API midair_status midair_field_bytes(const midair_field* field,
                                                void* bytes,
                                                size_t size,
                                                size_t* needed);
    /// Makes a field of bytes of midair_field_bytes(). MIDAIR_REFUSED: they are not those of one;
    /// MIDAIR_SILENT: of one that is silence.
    MIDAIR_API midair_status midair_field_from_bytes(const void* bytes,
                                                     size_t size,
                                                     midair_field** field);
    /// Closes the handle, and forgets the field.
    MIDAIR_API midair_status midair_field_close(midair_field* field);

#ifdef __cplusplus
}
#endif

#include "midair_extend.h"
#include "midair_play.h"

// NOLINTEND(modernize-deprecated-headers,readability-identifier-naming)
#endif
