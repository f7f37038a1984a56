#pragma once

#include <Eigen/Core>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace midair::base
{
class JsonValue;
}

namespace midair::haptics
{

/// Most reflectors of an array that aren't boards.
constexpr std::size_t kMostReflectors = 8;
/// Most planes of boards that reflect.
constexpr std::size_t kMostReflectingBoards = 8;

/// Largest distance of a transducer from its board's plane, beside the accuracy of that, metres.
constexpr double kOnBoard_m = 2e-3;

/// A flat rectangle at rest in the array frame that reflects sound on both sides: a table, a
/// screen, a half mirror, the case of an array.
struct Reflector
{
    /// Size of a side that has no end.
    static constexpr double kEndless = std::numeric_limits<double>::infinity();

    std::string name;                                   ///< in messages
    Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< centre, metres
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit length; either side
    Eigen::Vector3d along = Eigen::Vector3d::UnitX();   ///< unit length, along the first side
    Eigen::Vector2d size_m = {kEndless,
                              kEndless}; ///< along it and across; both without end or none
    /// Amplitude of the reflected wave over that of the wave which arrives, 0 .. 1. With 0 the
    /// reflector isn't there.
    double reflection = 1.0;
    double reflectionPhase_rad = 0.0; ///< added to the phase of the reflected wave
    double accuracy_mm = 0.0; ///< rms error of its place along its normal, above 0, at most 1000
    /// It is a board: the transducers in its plane stand on it. It reflects the sound of all
    /// others.
    bool isBoard = false;

    Eigen::Vector3d across() const; ///< unit length, along the second side
    /// Returns the distance of \a place from its plane, negative behind it, metres.
    double heightOf(const Eigen::Vector3d& place) const { return normal.dot(place - position); }
    /// Returns the mirror image of \a place.
    Eigen::Vector3d mirrored(const Eigen::Vector3d& place) const
    {
        return place - 2.0 * heightOf(place) * normal;
    }
    /// Returns the distance of \a place from the rectangle, metres.
    double distanceTo(const Eigen::Vector3d& place) const;
    /// Returns true if a transducer at \a place stands on it, and has no image in it nor a shadow.
    bool carries(const Eigen::Vector3d& place) const
    {
        return isBoard && std::abs(heightOf(place)) <= kOnBoard_m + 1e-3 * accuracy_mm;
    }
    /// Returns its name, or "reflector 0" for the one at \a index of a list.
    std::string called(std::size_t index) const;

    bool operator==(const Reflector& other) const;
    bool operator!=(const Reflector& other) const { return !(*this == other); }
};

/// Returns true if there can be another one among \a reflectors that isn't a board.
bool isRoomIn(const std::vector<Reflector>& reflectors);

/// Returns false if a value is out of range; \a error then names reflector and value.
bool areValid(const std::vector<Reflector>& reflectors, std::string* error = nullptr);

/// Reads {"reflectors": [..]} (samples/guides/ARRAYS.md); \a source: its name in messages. Throws
/// base::InputError: "source: path in the file what it is; what it must be".
std::vector<Reflector> reflectorsFromJson(const std::string& json, const std::string& source);
/// Reads only the list. Throws the same.
std::vector<Reflector> readReflectors(const base::JsonValue& list);
/// Returns the list as JSON text that is read back as equal reflectors.
std::string reflectorsToJson(const std::vector<Reflector>& reflectors);

} // namespace midair::haptics
