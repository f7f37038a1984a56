#ifndef MIDAIR_PLAY_H
#define MIDAIR_PLAY_H 1

// NOLINTBEGIN(modernize-deprecated-headers,readability-identifier-naming): this is C.

/// \file
/// Playing a scene, hands in, contacts out. Included by midair.h.

#include "midair.h"

#ifdef __cplusplus
extern "C"
{
#endif

    /// Plays the scene from now on, on the device of this URI: "sim:", "usb:", "record:FILE", a
    /// registered scheme, several with commas in between (DEVICES.md). Returns at once: array
    /// and device are opened on a thread of the scene's, midair_state() says how that goes, and
    /// midair_messages() why it failed. Another device replaces the one before.
    MIDAIR_API midair_status midair_play(midair_scene* scene, const char* device);
    /// Takes the scene as it is now, with its hands, to the device: to be called with each frame,
    /// moved or not, by one thread. Never waits for a solve or a device; a frame that comes before
    /// the last one is solved takes its place. \a time_s: of the frame, on the clock of the hand
    /// source; finite and not decreasing. MIDAIR_NOT_YET without midair_play(); MIDAIR_SILENCED,
    /// and the array is silent, while a value that concerns safety isn't understood, be it the
    /// scene's or one of the user's variables (C.md).
    MIDAIR_API midair_status midair_update(midair_scene* scene, double time_s);
    /// Ends playing: silences at once, then closes the device, which takes some milliseconds; waits
    /// for other calls with the scene and for an own solver that doesn't look at is_stopped.
    MIDAIR_API midair_status midair_stop(midair_scene* scene);
    /// 1: silences the array at once and keeps it silent; 0: plays again, what is newest. Waits for
    /// no other call.
    MIDAIR_API midair_status midair_mute(midair_scene* scene, int32_t muted);

    /// What an array does; midair::bridge::ArrayState of C++, and scene.state["state"] of Python,
    /// have the same names.
    enum
    {
        MIDAIR_STATE_CLOSED = 0,  ///< no device is open: none is wanted, or it can't be opened
        MIDAIR_STATE_OPENING = 1, ///< array and device are being opened
        MIDAIR_STATE_SILENT = 2, ///< ready, and there is nothing to play, or what there is can't be
        MIDAIR_STATE_PLAYING = 3, ///< plays what it is sent
        MIDAIR_STATE_MUTED = 4,   ///< by midair_mute()
        MIDAIR_STATE_LOST = 5,    ///< unplugged or failing; plays again by itself when it is back
        /// connected, but it refuses, hangs, doesn't play what it is sent, or may sound on although
        /// it was to be silent
        MIDAIR_STATE_FAULT = 6
    };

    /// sent = played + dropped + lost + refused + waiting, since the device was opened.
    typedef struct midair_device_state
    {
        int32_t state;       ///< MIDAIR_STATE_..
        int32_t reserved;    ///< 0
        uint64_t sent;       ///< fields handed to the device
        uint64_t played;     ///< as the device says; one that never answers: handed over whole
        uint64_t dropped;    ///< a newer field or a silence came first
        uint64_t lost;       ///< on the way, or in the device
        uint64_t refused;    ///< not taken by the device
        uint64_t waiting;    ///< on the way, or not confirmed yet
        uint64_t faults;     ///< stalls, unplugs, watchdogs and the like
        uint64_t reconnects; ///< times that the device came back
    } midair_device_state;

    /// What the array does, and what became of the fields that it was sent.
    MIDAIR_API midair_status midair_state(midair_scene* scene, midair_device_state* state);
    /// One line about the device. As midair_get().
    MIDAIR_API midair_status midair_device_status(midair_scene* scene,
                                                  char* text,
                                                  size_t size,
                                                  size_t* needed);
    /// What the user should know of all that was played, solved and opened so far, each once, in
    /// lines. As midair_get().
    MIDAIR_API midair_status midair_messages(midair_scene* scene,
                                             char* text,
                                             size_t size,
                                             size_t* needed);
    /// How bad what a message says is.
    enum
    {
        MIDAIR_NOTICE = 0,  ///< something is done otherwise than one may think
        MIDAIR_WARNING = 1, ///< something is left out, or not done as it was asked for
        MIDAIR_FAULT = 2    ///< nothing is played
    };

    /// A message about the scene; its codes are in MESSAGES.md. It is active from when it is
    /// said until what it says has ended: the device is back, the setting is corrected. One about
    /// what has happened is never active.
    typedef struct midair_message
    {
        uint64_t number;      ///< of this message; never given twice in a scene
        midair_object object; ///< that it is about; 0: none
        uint64_t count;       ///< how often it was said
        double since_s;       ///< s, CLOCK_MONOTONIC: when it began to hold, or was said last
        double until_s;       ///< s, the same clock: when it ended; 0 while it is active
        int32_t severity;     ///< MIDAIR_NOTICE, _WARNING or _FAULT
        int32_t active;       ///< 1: what it says holds
        char code[32];        ///< "device.lost", with its end
    } midair_message;

    /// Copies all messages that are kept, at most 100, the oldest first; \a count: how many there
    /// are, also where \a capacity is too small.
    MIDAIR_API midair_status midair_list_messages(midair_scene* scene,
                                                  midair_message* messages,
                                                  size_t capacity,
                                                  size_t* count);
    /// The sentence of one of them, by its number. As midair_get().
    MIDAIR_API midair_status midair_message_text(
        midair_scene* scene, uint64_t number, char* text, size_t size, size_t* needed);
    /// Forgets all messages that are not active.
    MIDAIR_API midair_status midair_clear_messages(midair_scene* scene);
    /// Gets each message that was said, has begun or has ended. Called by midair_update() before it
    /// returns, on its thread; it may call functions with the scene, but no midair_update(). \a
    /// message and \a text are valid during the call.
    typedef void (*midair_message_callback)(void* user,
                                            const midair_message* message,
                                            const char* text);
    /// Sets the callback; NULL: none. It is told of all messages that are kept the first time.
    MIDAIR_API midair_status midair_on_message(midair_scene* scene,
                                               midair_message_callback callback,
                                               void* user);
    /// The newest field that was played; MIDAIR_NOT_YET: none so far; MIDAIR_SILENT: it is silence,
    /// be it that nothing is wanted or that a solver has failed. Each call gives a handle of its
    /// own.
    MIDAIR_API midair_status midair_newest_field(midair_scene* scene, midair_field** field);
    /// The same once the field of the newest midair_update() is there, for which it waits at most
    /// \a timeout_s (>= 0). It may be called by the thread that updates, too, and keeps no other
    /// call waiting. MIDAIR_NOT_YET: it isn't there by then, or none comes, at once, as after
    /// midair_stop(); MIDAIR_SILENCED, at once, as of midair_update().
    MIDAIR_API midair_status midair_wait_field(midair_scene* scene,
                                               double timeout_s,
                                               midair_field** field);

    // --- Ears ------------------------------------------------------------------------------------

    /// Sets where ears are, from the next midair_update() or midair_solve() on: \a positions x, y,
    /// z of each of \a count, 0 .. 64, which replace those before. They are listened at besides the
    /// places around the array and the setting "earPoints", and the ear limit holds there as well.
    /// A place that isn't finite is an error, and nothing is played until all are right.
    MIDAIR_API midair_status midair_set_ears(midair_scene* scene,
                                             const double* positions,
                                             size_t count);

    /// How loud it is at an ear, as of now: levels in dB re 20 uPa, rms, as those of
    /// samples/guides/SAFETY.md.
    typedef struct midair_ear
    {
        double position[3]; ///< m, array frame
        double level_dB;    ///< of what is played now; 0: silence
        double eq_dB;       ///< mean since there are as many places as now
        double max_dB;      ///< highest mean over 1 s
    } midair_ear;

    /// Copies what is heard at each ear of midair_set_ears(), in their order, then at each place of
    /// "earPoints"; \a count: how many these are, also where \a capacity is too small. 0 before
    /// the first field.
    MIDAIR_API midair_status midair_ears(midair_scene* scene,
                                         midair_ear* ears,
                                         size_t capacity,
                                         size_t* count);

    // --- Hands -----------------------------------------------------------------------------------

#define MIDAIR_JOINTS 26 ///< of a hand

    /// One joint; in a hand they are in the order of OpenXR's XR_EXT_hand_tracking: palm, wrist,
    /// thumb metacarpal to tip, then metacarpal to tip of the index, middle, ring and little
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
        double age_s;                       ///< >= 0; how long before this call the tracker saw it
        midair_joint joints[MIDAIR_JOINTS]; ///< in the order that midair_joint says
    } midair_hand;

    /// Sets the hands for the updates that follow; they are gone 0.2 s after the last call. At
    /// most 64. A joint that is valid and not finite, or out of its ranges, is an error, and the
    /// hands before are gone.
    MIDAIR_API midair_status midair_set_hands(midair_scene* scene,
                                              const midair_hand* hands,
                                              size_t count);
    /// Takes the hands from a source instead: "recorded:FILE", "recorded:FILE?loop", "openxr:",
    /// "osc:", with their options (samples/guides/HANDS.md), or "NAME:options" of
    /// midair_register_hands(); "" or "none": from midair_set_hands() again. A recording's times
    /// are those of midair_update(). What a source has to say is in midair_messages().
    MIDAIR_API midair_status midair_open_hands(midair_scene* scene, const char* source);
    /// The flat open hand of an adult with the tip of its index finger at \a tip. In the frame
    /// turned by \a orientation (x, y, z, w) the fingers point along -z and the back of the hand
    /// along +y.
    MIDAIR_API midair_status midair_make_hand(int32_t id,
                                              const double tip[3],
                                              const double orientation[4],
                                              midair_hand* hand);

    // --- Head ------------------------------------------------------------------------------------

    /// Where the viewer's head is. It looks along its -z, with +y up and +x to its right.
    typedef struct midair_head
    {
        double position[3];    ///< m, array frame, at most 1000 from its origin: between the eyes
        double orientation[4]; ///< x, y, z, w; of length 1
        double age_s;          ///< >= 0; how long before this call the tracker saw it
    } midair_head;

    /// Sets the head for the updates that follow; 0.2 s after the last call it is lost. Its ears,
    /// 8 cm to the left and to the right, are listening places as those of midair_set_ears() are,
    /// and after it was lost they count where they were last. NULL: there is no head any more. A
    /// head that can't be is an error, and the one before is lost.
    MIDAIR_API midair_status midair_set_head(midair_scene* scene, const midair_head* head);
    /// Takes the head from a source instead: "fixed X Y Z" (m), "recorded:FILE",
    /// "recorded:FILE?loop", "openxr:", "osc:" (engine-bridge/hands/HANDS.md), or "NAME:options" of
    /// midair_register_head(); "" or "none": from midair_set_head() again. As midair_open_hands()
    /// otherwise.
    MIDAIR_API midair_status midair_open_head(midair_scene* scene, const char* source);
    /// Copies the head of the last midair_update(), predicted as hands are, to \a head.
    /// MIDAIR_NOT_YET: no head is tracked.
    MIDAIR_API midair_status midair_last_head(midair_scene* scene, midair_head* head);

    /// Where a hand touches an object whose property "render", or the scene's, is contact or auto.
    typedef struct midair_contact
    {
        uint64_t id;          ///< of the contact; never given twice
        midair_object object; ///< the one that is touched
        int32_t hand;         ///< midair_hand.id
        uint32_t foci;        ///< number of foci that are played now
        double centre[3];     ///< m; of the patch of the object inside the hand
        double normal[3];     ///< of length 1, out of the object
        double depth_m;       ///< how deep the finger is in the object
        double area_m2;       ///< of the patch
        double semi_major_m;  ///< of its ellipse
        double semi_minor_m;  ///< the shorter half axis
        double speed_m_s;     ///< of the finger along the object
        double pressure_Pa;   ///< peak; wanted at the first focus; 0: there is none
        double share;         ///< 0 .. 1; factor on the pressure while it fades
    } midair_contact;

    /// A finger near an object whose property "touchEvents" is true, as of the last
    /// midair_update().
    typedef struct midair_touch
    {
        midair_object object; ///< the one that is near
        int32_t hand;         ///< midair_hand.id
        int32_t finger;       ///< 0 thumb .. 4 little finger, 5 palm
        int32_t touching;     ///< 1: it touches; 0: it is within 50 mm
        int32_t reserved;     ///< 0
        double position[3];   ///< m; the nearest place of the object
        double distance_m;    ///< from the skin to the surface; below 0: it is in the object
        double force_N;       ///< an upper estimate; 0 while nothing is played
    } midair_touch;

    /// Copies the contacts of the newest field; \a count: how many there are, also where \a
    /// capacity is too small.
    MIDAIR_API midair_status midair_contacts(midair_scene* scene,
                                             midair_contact* contacts,
                                             size_t capacity,
                                             size_t* count);
    /// The same of touches.
    MIDAIR_API midair_status midair_touches(midair_scene* scene,
                                            midair_touch* touches,
                                            size_t capacity,
                                            size_t* count);

#ifdef __cplusplus
}
#endif

// NOLINTEND(modernize-deprecated-headers,readability-identifier-naming)
#endif
