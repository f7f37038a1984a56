#pragma once

#include "haptics/array/Directivity.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// The model is not used nearer to a transducer than this, about its radius: R is never taken
/// smaller.
constexpr double kNearestDistance_m = 5e-3;

/// Which activations a device can play: the solver is told, the device encodes.
struct DriveResolution
{
    int phaseLevels = 256; ///< phases are multiples of 2 pi / phaseLevels; 0: continuous
    std::vector<float> amplitudeLevels; ///< ascending, in [0, 1], the last one 1; empty: continuous
};

/// Transducers in the array frame (right-handed, metres, origin at the centre of the workspace, y
/// along the prism's axis).
struct TransducerArray
{
    std::string name;
    double frequency_Hz = 40e3;
    double sourceAmplitude_Pa_m = 10.1; ///< P0: peak pressure times distance on axis at full drive
    Directivity directivity = Directivity::T4010A1_HARMONICS;
    Eigen::Matrix3Xd positions; ///< 3 x m, metres
    Eigen::Matrix3Xd normals;   ///< 3 x m, unit length, the direction of emission
    /// m or empty: added by the transducer to what it is driven with
    Eigen::VectorXd phaseOffset_rad;
    Eigen::VectorXd gain;   ///< m or empty: multiplies the amplitude
    std::vector<int> board; ///< m: which board each transducer sits on, ascending from 0
    DriveResolution drive;

    int size() const { return static_cast<int>(positions.cols()); }

    /// 16 boards of 249 as the eight sides of a prism round the y axis, 3984 in all; P0 = 2.73 Pa m
    /// (physics of the paper's device).
    static TransducerArray octagonalPrism();
    /// One board of 249 in the plane z = 0, facing +z.
    static TransducerArray singleBoard();
    /// "octagon", "board", a shipped array's name (names() lists them), or the path of a JSON file.
    /// Throws InputError.
    static TransducerArray load(const std::string& nameOrPath);

    /// What load knows without a path: "octagon", "board", then every NAME.json in the folders of
    /// the environment variable OSG_MIDAIR_ARRAYS (colons between them), of the installation and of
    /// the source tree.
    static std::vector<std::string> names();

    /// Reads the array that \a json describes (haptics/arrays/README.md says how); \a source names
    /// it in messages. Throws InputError: "source: path in the file: what it is; what it must be".
    static TransducerArray fromJson(const std::string& json, const std::string& source);

    /// A text that fromJson reads back as an equal array.
    std::string toJson() const;

    /// Writes toJson() to \a path. Throws InputError where that is not possible.
    void save(const std::string& path) const;

    /// False where lengths disagree or a value can't be: \a error then says which. Loaded arrays
    /// are valid.
    bool isValid(std::string* error = nullptr) const;
};

} // namespace midair::haptics
