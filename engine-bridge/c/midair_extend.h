#ifndef MIDAIR_EXTEND_H
#define MIDAIR_EXTEND_H 1

// NOLINTBEGIN(modernize-deprecated-headers,readability-identifier-naming): this is C.

/// \file
/// Devices, solvers and hand sources of the program. Included by midair.h.
///
/// Registrations last for the rest of the program: functions and user data must outlive it. Structs
/// are copied whole by midair_register_..(); set struct_size to the struct's sizeof, and unused
/// members to 0. A name has 1 .. 32 small letters (solvers and hands: also digits and dashes); a
/// name that is taken gives MIDAIR_REFUSED.
///
/// Callbacks must not call functions with the scene that calls them. In C++ programs an exception
/// from a callback counts as its failure. \a error is room for a sentence with its terminator.

#include "midair.h"

#ifdef __cplusplus
extern "C"
{
#endif

    /// Driver of an array. The library enforces the limits of every device: it removes their
    /// parameters (max-amplitude, ramp, hold, ..) from the URI. The library calls the driver from
    /// its own threads, one call at a time, and nothing waits for a call; a call of more than 1 s
    /// is a fault until it returns.
    typedef struct midair_driver
    {
        size_t struct_size; ///< sizeof(midair_driver)
        void* user;         ///< passed to open()
        /// Opens "SCHEME:path?options"; \a options has lines KEY=VALUE. \a boards: board of each
        /// transducer, counting up from 0. Returns an instance, or NULL with the reason in \a
        /// error.
        void* (*open)(void* user,
                      const char* path,
                      const char* options,
                      const int32_t* boards,
                      uint32_t transducers,
                      char* error,
                      size_t error_size);
        /// Plays a field until the next one or silence(): level L of \a phases means e^{+j 2 pi
        /// L/phase_levels}, \a amplitudes are indices into the amplitudes below. Returns 0, or
        /// another number if the device didn't accept it.
        int32_t (*play)(void* instance, const uint8_t* phases, const uint8_t* amplitudes);
        /// Turns all transducers off. Returns 0, or another number if it failed; it is then called
        /// again.
        int32_t (*silence)(void* instance);
        /// Returns 0 while the device is lost. NULL: it is never lost.
        int32_t (*is_ready)(void* instance);
        /// Writes one line about the device. NULL: no status.
        void (*status)(void* instance, char* text, size_t size);
        /// Called once, last, after silence(). NULL: nothing to close.
        void (*close)(void* instance);
        uint32_t phase_levels;    ///< 2 .. 256; 0: 256
        uint32_t amplitude_count; ///< number of amplitudes
        const float*
            amplitudes; ///< 2 .. 256, rising from 0 to 1; NULL: 256, where L is sin(pi L/510)
        double fields_per_second; ///< highest accepted rate; 0: unlimited
    } midair_driver;

    /// Registers the scheme of a device: midair_play(scene, "mine:path?a=b") then plays on "mine".
    MIDAIR_API midair_status midair_register_device(const char* scheme,
                                                    const midair_driver* driver);

    /// Input of a solver; valid during the call only.
    typedef struct midair_problem
    {
        size_t struct_size;      ///< sizeof(midair_problem)
        uint32_t points;         ///< n, at least 1
        uint32_t transducers;    ///< m
        const double* positions; ///< 3 n: x, y, z of each point, array frame
        const double* targets;  ///< n, all above 0; in Pa if in_pascal, otherwise only ratios count
        const float* matrix;    ///< n x m, row by row, real and imaginary part: Pa at full drive
        double loudness;        ///< the scene's setting
        double deadline_ms;     ///< 0: none
        int32_t in_pascal;      ///< 1: targets are in Pa; 0: only their ratios count
        int32_t phase_only;     ///< 1: all amplitudes should be equal
        int32_t max_iterations; ///< 0: the solver's own limit
        int32_t reserved;       ///< 0
        /// Returns 1 when the field is no longer needed; then return soon. Call it with the
        /// problem.
        int32_t (*is_stopped)(const struct midair_problem* problem);
        const void* internal; ///< used by the library
    } midair_problem;

    /// Computes \a activations: real and imaginary part of m values, zero on entry; |q| <= 1.
    /// Returns 0, or another number with the reason in \a error if it finds no field:
    /// midair_solve() then returns MIDAIR_FAILED; a playing scene falls silent and reports it in
    /// midair_messages(). The library checks, rounds, caps and measures the result.
    typedef int32_t (*midair_solve_function)(void* user,
                                             const midair_problem* problem,
                                             float* activations,
                                             char* error,
                                             size_t error_size);

    /// Registers a solver: midair_set(scene, "solver", "mine") selects it. \a solve is called on
    /// the thread of midair_solve() or on a thread of the library, possibly at the same time for
    /// different scenes and for fields in turn.
    MIDAIR_API midair_status midair_register_solver(const char* name,
                                                    midair_solve_function solve,
                                                    void* user);

    struct midair_hand; // midair_play.h

    /// Source of hands. Its functions are called by midair_open_hands(), midair_update() and
    /// midair_scene_close(), on their threads; they must not block.
    typedef struct midair_hand_source
    {
        size_t struct_size; ///< sizeof(midair_hand_source)
        void* user;         ///< passed to open()
        /// \a options: the text after "NAME:". Returns an instance, or NULL with the reason in \a
        /// error.
        void* (*open)(void* user, const char* options, char* error, size_t error_size);
        /// Fills \a hands with the hands at \a time_s of midair_update(). Returns their number, at
        /// most \a capacity; below 0: none are known.
        int32_t (*hands)(void* instance, double time_s, struct midair_hand* hands, size_t capacity);
        /// Called once, last. NULL: nothing to close.
        void (*close)(void* instance);
    } midair_hand_source;

    /// Registers a hand source: midair_open_hands() then takes "NAME:options".
    MIDAIR_API midair_status midair_register_hands(const char* name,
                                                   const midair_hand_source* source);

    struct midair_head; // midair_play.h

    /// Source of the head; like midair_hand_source, for midair_open_head(). midair_solve() also
    /// calls head().
    typedef struct midair_head_source
    {
        size_t struct_size; ///< sizeof(midair_head_source)
        void* user;         ///< passed to open()
        /// \a options: the text after "NAME:". Returns an instance, or NULL with the reason in \a
        /// error.
        void* (*open)(void* user, const char* options, char* error, size_t error_size);
        /// Fills \a head with the head at \a time_s of midair_update(). Returns 1; 0: it is lost.
        int32_t (*head)(void* instance, double time_s, struct midair_head* head);
        /// Called once, last. NULL: nothing to close.
        void (*close)(void* instance);
    } midair_head_source;

    /// Registers a head source: midair_open_head() then takes "NAME:options".
    MIDAIR_API midair_status midair_register_head(const char* name,
                                                  const midair_head_source* source);

#ifdef __cplusplus
}
#endif

// NOLINTEND(modernize-deprecated-headers,readability-identifier-naming)
#endif
