#ifndef MIDAIR_EXTEND_H
#define MIDAIR_EXTEND_H 1

// NOLINTBEGIN(modernize-deprecated-headers,readability-identifier-naming): this is C.

/// \file
/// A program's own devices, solvers and hand sources. Included by midair.h.
///
/// What is registered stays so for the rest of the program: functions and user data have to outlive
/// it. All of a struct is copied by midair_register_..(); set its struct_size to its sizeof, and
/// what you leave out to 0. A name has 1 .. 32 small letters (solvers and hands: digits and dashes,
/// too); one that is taken is MIDAIR_REFUSED.
///
/// Callbacks may not call functions with the scene that calls them, and may not let exceptions out
/// that they can't stand: what a callback of a C++ program throws counts as its failure. \a error
/// is room for a sentence with its end.

#include "midair.h"

#ifdef __cplusplus
extern "C"
{
#endif

    /// Driver of an array. The limits of all devices hold for it: their parameters (max-amplitude,
    /// ramp, hold, ..) are taken off the URI. It is called from threads of the library's own, one
    /// call at a time; nobody waits for one, and one that takes over 1 s is a fault until it
    /// returns.
    typedef struct midair_driver
    {
        size_t struct_size; ///< sizeof(midair_driver)
        void* user;         ///< given to open()
        /// Opens "SCHEME:path?options"; \a options are lines KEY=VALUE. \a boards: of each
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
        /// L/phase_levels}, \a amplitudes are indices into the amplitudes below. Returns 0;
        /// anything else: the device didn't take it.
        int32_t (*play)(void* instance, const uint8_t* phases, const uint8_t* amplitudes);
        /// Turns all transducers off. Returns 0; anything else: it failed, and is called again.
        int32_t (*silence)(void* instance);
        /// Returns 0 while the device is lost. NULL: it never is.
        int32_t (*is_ready)(void* instance);
        /// Writes one line about the device. NULL: there is nothing to say.
        void (*status)(void* instance, char* text, size_t size);
        /// Called once, last, after silence(). NULL: nothing is to be closed.
        void (*close)(void* instance);
        uint32_t phase_levels;    ///< 2 .. 256; 0: 256
        uint32_t amplitude_count; ///< number of amplitudes
        const float*
            amplitudes; ///< 2 .. 256 that rise from 0 to 1; NULL: 256, of which L is sin(pi L/510)
        double fields_per_second; ///< the most that it takes; 0: any number
    } midair_driver;

    /// Registers the scheme of a device: "mine" is played on by midair_play(scene,
    /// "mine:path?a=b").
    MIDAIR_API midair_status midair_register_device(const char* scheme,
                                                    const midair_driver* driver);

    /// What a solver is asked for; valid during the call only.
    typedef struct midair_problem
    {
        size_t struct_size;      ///< sizeof(midair_problem)
        uint32_t points;         ///< n, at least 1
        uint32_t transducers;    ///< m
        const double* positions; ///< 3 n: x, y, z of each point, array frame
        const double* targets;   ///< n, all above 0; Pa if in_pascal, else only the ratios count
        const float* matrix;     ///< n x m, row by row, real and imaginary part: Pa at full drive
        double loudness;         ///< as the scene asks for it
        double deadline_ms;      ///< 0: none
        int32_t in_pascal;       ///< 1: targets are in Pa; 0: only their ratios count
        int32_t phase_only;      ///< 1: all amplitudes are to be equal
        int32_t max_iterations;  ///< 0: the solver's own limit
        int32_t reserved;        ///< 0
        /// Returns 1 when nobody waits for the field any more: return then, soon. Call it with the
        /// problem.
        int32_t (*is_stopped)(const struct midair_problem* problem);
        const void* internal; ///< of the library
    } midair_problem;

    /// Finds \a activations, real and imaginary part of each of m, zeros when it is called; |q|
    /// <= 1. Returns 0; anything else, with the reason in \a error: there is no field, and
    /// midair_solve() is MIDAIR_FAILED; a scene that plays falls silent, and says so in its
    /// midair_messages(). What it finds is checked, rounded, capped and measured.
    typedef int32_t (*midair_solve_function)(void* user,
                                             const midair_problem* problem,
                                             float* activations,
                                             char* error,
                                             size_t error_size);

    /// Registers a solver: midair_set(scene, "solver", "mine") uses it. \a solve is called on the
    /// thread of midair_solve() or on one of the library's, for different scenes and fields in turn
    /// at the same time, too.
    MIDAIR_API midair_status midair_register_solver(const char* name,
                                                    midair_solve_function solve,
                                                    void* user);

    struct midair_hand; // midair_play.h

    /// Source of hands. All is called by midair_open_hands(), midair_update() and
    /// midair_scene_close(), on their threads; it must not block.
    typedef struct midair_hand_source
    {
        size_t struct_size; ///< sizeof(midair_hand_source)
        void* user;         ///< given to open()
        /// \a options: what stands behind "NAME:". Returns an instance, or NULL with the reason in
        /// \a error.
        void* (*open)(void* user, const char* options, char* error, size_t error_size);
        /// Fills \a hands with those at \a time_s, of midair_update(). Returns their number, at
        /// most \a capacity; below 0: none are known.
        int32_t (*hands)(void* instance, double time_s, struct midair_hand* hands, size_t capacity);
        /// Called once, last. NULL: nothing is to be closed.
        void (*close)(void* instance);
    } midair_hand_source;

    /// Registers a hand source: midair_open_hands() then takes "NAME:options".
    MIDAIR_API midair_status midair_register_hands(const char* name,
                                                   const midair_hand_source* source);

    struct midair_head; // midair_play.h

    /// Source of the head; as midair_hand_source, of midair_open_head(). midair_solve() calls
    /// head(), too.
    typedef struct midair_head_source
    {
        size_t struct_size; ///< sizeof(midair_head_source)
        void* user;         ///< given to open()
        /// \a options: what stands behind "NAME:". Returns an instance, or NULL with the reason in
        /// \a error.
        void* (*open)(void* user, const char* options, char* error, size_t error_size);
        /// Fills \a head with that at \a time_s, of midair_update(). Returns 1; 0: it is lost.
        int32_t (*head)(void* instance, double time_s, struct midair_head* head);
        /// Called once, last. NULL: nothing is to be closed.
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
