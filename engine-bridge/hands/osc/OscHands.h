#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/Head.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// \{ OSC addresses; samples/guides/HANDS.md has their arguments.
constexpr const char* kOscHand = "/midair/hand";
constexpr const char* kOscHead = "/midair/head";
constexpr const char* kOscText = "/midair/text";
constexpr const char* kOscHorizon = "/midair/horizon";
/// \}

/// Longer datagrams are refused: two hands take 2,600 bytes.
constexpr std::size_t kMostOscBytes = 8192;
constexpr double kOldestOscHand_s = 10.0; ///< largest age that a sender may report, also for heads
constexpr double kFarthestOscHorizon_s = 1.0; ///< limit of a requested prediction

/// Throws base::InputError in a build without OSC. Senders and receivers call it first.
void requireOsc();

/// Content of one datagram.
struct OscContent
{
    /// A hand with the sender's time.
    struct Timed
    {
        double time_s = 0.0; ///< the sender's clock, with an arbitrary zero
        Hand hand;           ///< age_s: at the time of sending
    };
    std::vector<Timed> hands;
    /// The newest head; time_s: the sender's clock, NaN if missing; age_s: at the time of sending.
    std::optional<Head> head;
    std::vector<std::string> texts; ///< messages of the sender for the user
    double horizon_s = -1.0;        ///< >= 0: requested prediction of hands; else: no request
    std::size_t jointsLeftOut = 0;  ///< marked as valid but impossible, including heads
    std::string firstLeftOut;       ///< problem of the first of them
    std::string unknown;            ///< first unknown address; empty: none
    std::size_t unknownCount = 0;
};

/// Decodes a datagram of \a size bytes: a message or a bundle, possibly nested. Throws
/// base::InputError for any error: a datagram is accepted completely or not at all. Reads no byte
/// outside of it, and keeps no reference.
OscContent decodeOsc(const char* data, std::size_t size);

/// Encodes datagrams: the bytes are valid until the next call.
class OscWriter
{
public:
    /// A bundle with a message for each of \a hands with id 0 or 1, others are left out; without
    /// hands an empty bundle, as a sign of life. \a time_s: the sender's clock, which must
    /// increase.
    std::size_t hands(const std::vector<Hand>& hands, double time_s);
    /// A head, at head.time_s of the sender's clock, which must increase.
    std::size_t head(const Head& head);
    std::size_t text(const std::string& text); ///< cut after 1000 bytes
    std::size_t horizon(double ahead_s);       ///< >= 0

    const char* data() const { return _bytes.data(); }

private:
    std::array<char, kMostOscBytes> _bytes{};
};

} // namespace midair::bridge
