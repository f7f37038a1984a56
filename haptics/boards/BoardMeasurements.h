#pragma once

#include "haptics/array/BoardGrid.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace midair::haptics
{

/// A reference place for measurements: a hook in the wall, or a microphone position.
struct MeasuredPlace
{
    std::string name;
    Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< m, array frame
    bool isKnown = true; ///< false: known approximately; it is fitted as well
};

/// One end of a measurement: a transducer, or a place.
struct MeasuredEnd
{
    std::string name;
    int transducer = -1; ///< -1: it is a place
    int place = -1;      ///< index; -1: it is a transducer
};

/// Distance between two ends, measured by tape or by the travel time of sound.
struct BoardMeasurement
{
    MeasuredEnd from, to;
    double distance_m = 0.0; ///< for tapes
    double time_s = 0.0;     ///< for times
    bool isTime = false;     ///< with a delay common to all times, which is fitted as well
    int line = 0;            ///< of the file, from 1

    std::string name() const { return from.name + " - " + to.name; }
};

/// Measurements of an array's boards.
struct BoardMeasurements
{
    std::vector<MeasuredPlace> places;
    std::vector<BoardMeasurement> all;
};

/// Names of an array's transducers in measurements: "3:17" is transducer 17 of board 3, both from
/// 0; "3:a" to "3:d" are the four at the corners of board 3; "t847" is transducer 847 of the array.
class BoardMarks
{
public:
    explicit BoardMarks(const TransducerArray& array);

    /// Returns the transducer's index. Throws base::InputError, with the valid names, for unknown
    /// names.
    int find(const std::string& name) const;
    /// Returns the transducer at corner \a letter, 'a' to 'd', of \a board.
    int corner(int board, char letter) const;
    int boards() const { return static_cast<int>(_boards.size()); }
    int boardOf(int transducer) const { return _boardOf[static_cast<std::size_t>(transducer)]; }

private:
    std::vector<BoardRange> _boards;
    std::vector<int> _boardOf;
    std::vector<std::array<int, 4>> _corners;
};

/// Parses measurements, one per line, with words separated by blanks, commas, semicolons or tabs:
///     place NAME x y z          a place that is known, metres or with a unit
///     place NAME about x y z    one that is known to some centimetres
///     END END DISTANCE          "0:a 1:b 151.2mm", metres without a unit
///     END END TIME              "t17 m1 683us": sound from the first to the second, or back
/// # begins a comment. \a source: name of the text in messages. Throws base::InputError, which
/// names the line.
BoardMeasurements readBoardMeasurements(const std::string& text,
                                        const std::string& source,
                                        const TransducerArray& array);

} // namespace midair::haptics
