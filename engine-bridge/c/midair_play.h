#ifndef MIDAIR_PLAY_H
#define MIDAIR_PLAY_H 1

// NOLINTBEGIN(modernize-deprecated-headers,readability-identifier-naming): this is C.

/// \file
/// Playing a scene, hands and contacts. Included by midair.h.

#include "midair.h"

#ifdef __cplusplus
extern "C"
{
#endif

    /// Plays the scene on the device of this URI: "sim:", "usb:", "record:FILE", a registered
    /// scheme, or several separated by commas (DEVICES.md). Returns at once: a thread of the scene
    /// opens array and device; midair_state() shows the progress, midair_messages() a failure. A
    /// new device replaces the one before.
    MIDAIR_API midair_status midair_play(midair_scene* scene, const char* device);
    /// Sends the present scene with its hands to the device. Call it once per frame, moved or not,
    /// from one thread. Never waits for a solve or a device; a frame that comes before the last one
    /// is solved replaces it. \a time_s: time of the frame on the hand source's clock; finite and
    /// not decreasing. MIDAIR_NOT_YET without midair_play(). MIDAIR_SILENCED, with a silent array,
    /// while a value that concerns safety is invalid, either of the scene or of one of the user's
    /// variables (C.md).
    MIDAIR_API midair_status midair_update(midair_scene* scene, double time_s);
    /// Stops playing: silences at once, then closes the device, which takes some milliseconds.
    /// Waits for other calls with the scene, and for a solver of the program that ignores
    /// is_stopped.
    MIDAIR_API midair_status midair_stop(midair_scene* scene);
    /// 1: silences the array at once and keeps it silent; 0: plays the newest field again. Waits
    /// for no other call.
    MIDAIR_API midair_status midair_mute(midair_scene* scene, int32_t muted);

    /// States of an array; midair::bridge::ArrayState of C++ and scene.state["state"] of Python
    /// have the same names.
    enum
    {
        MIDAIR_STATE_CLOSED = 0,  ///< no device is open: none is wanted, or opening failed
        MIDAIR_STATE_OPENING = 1, ///< array and device are being opened
        MIDAIR_STATE_SILENT = 2,  ///< ready, but there is nothing to play, or it can't be played
        MIDAIR_STATE_PLAYING = 3, ///< plays the fields that it is sent
        MIDAIR_STATE_MUTED = 4,   ///< muted by midair_mute()
        MIDAIR_STATE_LOST = 5,    ///< unplugged or failing; plays again by itself when it is back
        /// connected, but refuses, hangs, doesn't play its fields, or may still play although it
        /// was silenced
        MIDAIR_STATE_FAULT = 6
    };

    /// Counts since the device was opened: sent = played + dropped + lost + refused + waiting.
    typedef struct midair_device_state
    {
        int32_t state;       ///< MIDAIR_STATE_..
        int32_t reserved;    ///< 0
        uint64_t sent;       ///< fields handed to the device
        uint64_t played;     ///< confirmed; without confirmation: handed over whole
        uint64_t dropped;    ///< replaced by a newer field or a silence
        uint64_t lost;       ///< lost in transit or in the device
        uint64_t refused;    ///< not accepted by the device
        uint64_t waiting;    ///< in transit, or not confirmed yet
        uint64_t faults;     ///< stalls, unplugs, watchdog resets and so on
        uint64_t reconnects; ///< how often the device came back
    } midair_device_state;

    /// Gets the state of the array and the fate of the fields that it was sent.
    MIDAIR_API midair_status midair_state(midair_scene* scene, midair_device_state* state);
    /// Gets one line about the device; see midair_get().
    MIDAIR_API midair_status midair_device_status(midair_scene* scene,
                                                  char* text,
                                                  size_t size,
                                                  size_t* needed);
    /// Gets the messages for the user about playing, solving and opening so far, each once, one a
    /// line; see midair_get().
    MIDAIR_API midair_status midair_messages(midair_scene* scene,
                                             char* text,
                                             size_t size,
                                             size_t* needed);
    /// Severity of a message.
    enum
    {
        MIDAIR_NOTICE = 0,  ///< something works differently than one may expect
        MIDAIR_WARNING = 1, ///< something is left out, or not done as requested
        MIDAIR_FAULT = 2    ///< nothing is played
    };

    /// A message about the scene; its codes are in MESSAGES.md. It is active from its report until
    /// its condition ends: the device is back, the setting is corrected. Messages about past events
    /// are never active.
    typedef struct midair_message
    {
        uint64_t number;      ///< of this message; never reused in a scene
        midair_object object; ///< the object that it is about; 0: none
        uint64_t count;       ///< how often it was reported
        double since_s;       ///< s, CLOCK_MONOTONIC: start of its condition, or its last report
        double until_s;       ///< s, the same clock: when it ended; 0 while it is active
        int32_t severity;     ///< MIDAIR_NOTICE, _WARNING or _FAULT
        int32_t active;       ///< 1: its condition holds
        char code[32];        ///< "device.lost", with its terminator
    } midair_message;

    /// Copies all stored messages, at most 100, the oldest first; \a count: their number, even if
    /// \a capacity is too small.
    MIDAIR_API midair_status midair_list_messages(midair_scene* scene,
                                                  midair_message* messages,
                                                  size_t capacity,
                                                  size_t* count);
    /// Gets the sentence of a message by its number; see midair_get().
    MIDAIR_API midair_status midair_message_text(
        midair_scene* scene, uint64_t number, char* text, size_t size, size_t* needed);
    /// Deletes all messages that are not active.
    MIDAIR_API midair_status midair_clear_messages(midair_scene* scene);
    /// Receives each message that was reported, has begun or has ended. Called by midair_update()
    /// before it returns, on its thread; it may call functions with the scene, except
    /// midair_update(). \a message and \a text are valid during the call.
    typedef void (*midair_message_callback)(void* user,
                                            const midair_message* message,
                                            const char* text);
    /// Sets the callback; NULL: none. Its first call receives all stored messages.
    MIDAIR_API midair_status midair_on_message(midair_scene* scene,
                                               midair_message_callback callback,
                                               void* user);
    /// Gets the newest field that was played. MIDAIR_NOT_YET: none so far; MIDAIR_SILENT: it is
    /// silence, because nothing is wanted or a solver has failed. Each call returns a new handle.
    MIDAIR_API midair_status midair_newest_field(midair_scene* scene, midair_field** field);
    /// Waits up to \a timeout_s (>= 0) for the field of the newest midair_update() and gets it. The
    /// thread that updates may call it, too, and it blocks no other call. MIDAIR_NOT_YET: the field
    /// isn't ready in time, or (at once) none will come, as after midair_stop(); MIDAIR_SILENCED
    /// (at once): see midair_update().
    MIDAIR_API midair_status midair_wait_field(midair_scene* scene,
                                               double timeout_s,
                                               midair_field** field);

    // --- Ears ------------------------------------------------------------------------------------

    /// Sets the positions of ears from the next midair_update() or midair_solve() on: \a positions
    /// has x, y, z for each of \a count, 0 .. 64, and replaces those before. The level is computed
    /// and the ear limit holds there, besides the places around the array and the setting
    /// "earPoints". A position that isn't finite is an error, and nothing is played until all are
    /// valid.
    MIDAIR_API midair_status midair_set_ears(midair_scene* scene,
                                             const double* positions,
                                             size_t count);

    /// Sound level at an ear at present: levels in dB re 20 uPa, rms, like those of
    /// samples/guides/SAFETY.md.
    typedef struct midair_ear
    {
        double position[3]; ///< m, array frame
        double level_dB;    ///< of the present output; 0: silence
        double eq_dB;       ///< mean since the number of places last changed
        double max_dB;      ///< highest mean over 1 s
    } midair_ear;

    /// Copies the levels at the ears of midair_set_ears(), in their order, then at the places of
    /// "earPoints"; \a count: their number, even if \a capacity is too small. 0 before the first
    /// field.
    MIDAIR_API midair_status midair_ears(midair_scene* scene,
                                         midair_ear* ears,
                                         size_t capacity,
                                         size_t* count);

    // --- Reflectors ------------------------------------------------------------------------------

    /// Sets flat things that reflect sound, from the next midair_update() or midair_solve() on:
    /// \a json is {"reflectors": [..]} as in samples/guides/ARRAYS.md, in the array's frame. They
    /// replace those before, come besides those of the array, at most 8 together, and may move from
    /// update to update. NULL or "": none. What is left out, or not corrected for, is told by
    /// messages. A wrong text is an error, and nothing is played until it is right.
    MIDAIR_API midair_status midair_set_reflectors(midair_scene* scene, const char* json);

    // --- Hands -----------------------------------------------------------------------------------

#define MIDAIR_JOINTS 26 ///< joints of a hand

    /// One joint. The joints of a hand have the order of OpenXR's XR_EXT_hand_tracking: palm,
    /// wrist, thumb metacarpal to tip, then metacarpal to tip of the index, middle, ring and little
    /// finger.
    typedef struct midair_joint
    {
        double position[3];        ///< m, array frame, at most 1000 from its origin
        double orientation[4];     ///< x, y, z, w; of length 1
        double radius_m;           ///< above 0, at most 0.1; from the joint to the skin
        int32_t position_valid;    ///< 1: the tracker knows the position
        int32_t orientation_valid; ///< 1: the tracker knows the orientation
    } midair_joint;

    /// One hand.
    typedef struct midair_hand
    {
        int32_t id;                         ///< stable from frame to frame; 0 left, 1 right
        int32_t reserved;                   ///< 0
        double age_s;                       ///< >= 0; time since the tracker saw it, at this call
        midair_joint joints[MIDAIR_JOINTS]; ///< in the order of midair_joint
    } midair_hand;

    /// Sets the hands for the following updates, at most 64; they disappear 0.2 s after the last
    /// call. A valid joint that is not finite or out of its ranges is an error, and the hands
    /// before are dropped.
    MIDAIR_API midair_status midair_set_hands(midair_scene* scene,
                                              const midair_hand* hands,
                                              size_t count);
    /// Takes the hands from a source instead: "recorded:FILE", "recorded:FILE?loop", "openxr:",
    /// "osc:", with their options (samples/guides/HANDS.md), or "NAME:options" of
    /// midair_register_hands(). "" or "none": from midair_set_hands() again. A recording uses the
    /// times of midair_update(). Messages of the source are in midair_messages().
    MIDAIR_API midair_status midair_open_hands(midair_scene* scene, const char* source);
    /// Lists the hands of the last midair_update(), predicted to the time of the sound if the scene
    /// predicts, with their ages; none before it.
    MIDAIR_API midair_status midair_last_hands(midair_scene* scene,
                                               midair_hand* hands,
                                               size_t capacity,
                                               size_t* count);
    /// Makes the flat open hand of an adult with the tip of its index finger at \a tip. In the
    /// frame turned by \a orientation (x, y, z, w) the fingers point along -z and the back of the
    /// hand along +y.
    MIDAIR_API midair_status midair_make_hand(int32_t id,
                                              const double tip[3],
                                              const double orientation[4],
                                              midair_hand* hand);

    // --- Head ------------------------------------------------------------------------------------

    /// Pose of the viewer's head. It looks along its -z, with +y up and +x to its right.
    typedef struct midair_head
    {
        double position[3];    ///< m, array frame, at most 1000 from its origin: between the eyes
        double orientation[4]; ///< x, y, z, w; of length 1
        double age_s;          ///< >= 0; time since the tracker saw it, at this call
    } midair_head;

    /// Sets the head for the following updates; it is lost 0.2 s after the last call. Its ears, 8
    /// cm to the left and to the right, are listening places like those of midair_set_ears(); after
    /// a loss they stay at their last positions. NULL: there is no head any more. An invalid head
    /// is an error, and the one before is lost.
    MIDAIR_API midair_status midair_set_head(midair_scene* scene, const midair_head* head);
    /// Takes the head from a source instead: "fixed X Y Z" (m), "recorded:FILE",
    /// "recorded:FILE?loop", "openxr:", "osc:" (engine-bridge/hands/HANDS.md), or "NAME:options" of
    /// midair_register_head(). "" or "none": from midair_set_head() again. Otherwise like
    /// midair_open_hands().
    MIDAIR_API midair_status midair_open_head(midair_scene* scene, const char* source);
    /// Copies the head of the last midair_update(), predicted like hands, to \a head.
    /// MIDAIR_NOT_YET: no head is tracked.
    MIDAIR_API midair_status midair_last_head(midair_scene* scene, midair_head* head);

    // --- Seen and felt ---------------------------------------------------------------------------

    /// Sets the display that shows the scene: a *.display.json (samples/guides/DISPLAYS.md) in the
    /// array's frame; "": none. If it names a head source and none is open or set, that source is
    /// opened like by midair_open_head(). The library draws nothing: midair_list_coincidence()
    /// needs the display.
    MIDAIR_API midair_status midair_set_display(midair_scene* scene, const char* file);

    /// Parts of the coincidence error (how far an object is seen from where it is felt), and their
    /// total.
    enum
    {
        MIDAIR_PART_ARRAY = 0,   ///< pose of the array
        MIDAIR_PART_DISPLAY = 1, ///< pose of the display
        MIDAIR_PART_EYE = 2,     ///< position of the head
        MIDAIR_PART_IPD = 3,     ///< distance between the eyes
        MIDAIR_PART_AIR = 4,     ///< temperature of the air
        MIDAIR_PART_MOTION = 5,  ///< motion between light and sound that isn't compensated
        MIDAIR_PART_TRACKER = 6, ///< position of the hand, for objects played by contacts
        MIDAIR_PART_TOTAL = 7,   ///< known if none of the others is unknown
        MIDAIR_PARTS = 8
    };
    /// State of a part.
    enum
    {
        MIDAIR_PART_UNKNOWN = 0, ///< its numbers are meaningless
        MIDAIR_PART_KNOWN = 1,
        MIDAIR_PART_NONE = 2 ///< the object has no such error
    };

    /// Coincidence error of an object, by parts (MIDAIR_PART_ ..).
    typedef struct midair_coincidence
    {
        midair_object object;
        double median_m[MIDAIR_PARTS]; ///< half of all errors are smaller
        double most_m[MIDAIR_PARTS];   ///< 95 % of all errors are smaller
        int32_t state[MIDAIR_PARTS];   ///< MIDAIR_PART_UNKNOWN, _KNOWN or _NONE
        char largest[16];              ///< name of the largest known part, with its terminator
        char unknown[256]; ///< why the total is unknown, with its terminator; empty: it is known
    } midair_coincidence;

    /// Copies the coincidence errors of the first 16 objects of the newest update; \a count: their
    /// number, even if \a capacity is too small. 0 while nothing is played.
    MIDAIR_API midair_status midair_list_coincidence(midair_scene* scene,
                                                     midair_coincidence* list,
                                                     size_t capacity,
                                                     size_t* count);

    /// Contact of a hand and an object whose property "render" (or the scene's) is contact or auto.
    typedef struct midair_contact
    {
        uint64_t id;          ///< of the contact; never reused
        midair_object object; ///< the touched object
        int32_t hand;         ///< midair_hand.id
        uint32_t foci;        ///< number of foci played now
        double centre[3];     ///< m; of the part of the object inside the hand
        double normal[3];     ///< of length 1, out of the object
        double depth_m;       ///< how deep the finger is in the object
        double area_m2;       ///< of the patch
        double semi_major_m;  ///< of its ellipse
        double semi_minor_m;  ///< the shorter half axis
        double speed_m_s;     ///< of the finger along the object
        double pressure_Pa;   ///< peak pressure wanted at the first focus; 0: no focus
        double share;         ///< 0 .. 1; factor on the pressure while it fades
    } midair_contact;

    /// A finger near an object whose property "touchEvents" is true, as of the last
    /// midair_update().
    typedef struct midair_touch
    {
        midair_object object; ///< the near object
        int32_t hand;         ///< midair_hand.id
        int32_t finger;       ///< 0 thumb .. 4 little finger, 5 palm
        int32_t touching;     ///< 1: it touches; 0: it is within 50 mm
        int32_t reserved;     ///< 0
        double position[3];   ///< m; nearest point of the object
        double distance_m;    ///< from the skin to the surface; below 0: inside the object
        double force_N;       ///< an upper estimate; 0 while nothing is played
    } midair_touch;

    /// A sensation of an object, as of the newest field.
    typedef struct midair_sensation
    {
        midair_object object;
        int32_t playing;        ///< 1: from its begin until it has faded out
        int32_t stopped;        ///< 1: its pattern has come to its stop
        double pattern_time_ms; ///< time in the pattern, which jumps and speed change
        double position[3];     ///< m, array frame; of the focus
        double intensity;       ///< 0 .. 1, with fades
        double pressure_Pa;     ///< wanted peak
    } midair_sensation;

    /// Copies the sensations of the newest field, like midair_contacts().
    MIDAIR_API midair_status midair_sensations(midair_scene* scene,
                                               midair_sensation* sensations,
                                               size_t capacity,
                                               size_t* count);
    /// Begins the sensation of \a object anew with the next midair_update(), or ends it: \a plays
    /// 0. Its property "trigger" must be program.
    MIDAIR_API midair_status midair_sensation_play(midair_scene* scene,
                                                   midair_object object,
                                                   int32_t plays);
    /// Copies the contacts of the newest field; \a count: their number, even if \a capacity is too
    /// small.
    MIDAIR_API midair_status midair_contacts(midair_scene* scene,
                                             midair_contact* contacts,
                                             size_t capacity,
                                             size_t* count);
    /// Copies the touches, like midair_contacts().
    MIDAIR_API midair_status midair_touches(midair_scene* scene,
                                            midair_touch* touches,
                                            size_t capacity,
                                            size_t* count);

#ifdef __cplusplus
}
#endif

// NOLINTEND(modernize-deprecated-headers,readability-identifier-naming)
#endif
