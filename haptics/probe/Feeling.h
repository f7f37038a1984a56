#pragma once

namespace midair::haptics
{

/// How a field is played on the skin.
enum class PlayedAs
{
    HELD,      ///< it rests; a hand feels of it what changes as it moves
    VIBRATING, ///< its amplitude is modulated
    CIRCLING   ///< foci circle on the skin, as `contact` plays
};

/// What feelingOf() says of what most people don't feel.
constexpr const char* kTooWeak = "too weak to feel";

/// What most people feel of a force of \a force_N on a fingertip: "too weak to feel", "faint",
/// "clear" or "strong". An estimate: of ultrasound on skin absolute thresholds are published for
/// few conditions, of which CONCEPTS.md, "How many pascals?", names each. The steps (mN) are those
/// of its table: held 1, 20 and 60; vibrating 0.1, 1 and 10; circling 1, 5 and 15.
const char* feelingOf(double force_N, PlayedAs how);

} // namespace midair::haptics
