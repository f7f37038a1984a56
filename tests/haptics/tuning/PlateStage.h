#pragma once

#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/tuning/ReflectorFit.h"
#include "tests/haptics/tuning/Rehearsal.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

/// A plate before a board whose sound is made apart from the fit: a reflected wave is that of the
/// array's mirror image, placed by hand.
namespace midair::haptics
{

/// A board, a plate before it, and what is known of both: phases and gains are off by what a tuning
/// leaves, the microphone by 2 mm, the guess of the plate by millimetres and a degree.
struct PlateStage
{
    TransducerArray truth = TransducerArray::singleBoard();
    TransducerArray tuned; ///< as a tuning leaves it
    TuningPlan plan;
    Reflector plate, guess;
    Medium air;
    double noise = 0.02; ///< over the rms of a place's readings
    std::mt19937 random;

    explicit PlateStage(int places = 3, unsigned seed = 7) : random(seed)
    {
        air.temperature_C = 20.7;
        std::normal_distribution<double> normal;
        const int m = truth.size();
        truth.phaseOffset_rad.resize(m);
        truth.gain.resize(m);
        tuned = truth;
        for (int i = 0; i < m; ++i)
        {
            truth.phaseOffset_rad[i] = 0.26 * normal(random);
            truth.gain[i] = 1.0 + 0.1 * normal(random);
            tuned.phaseOffset_rad[i] = truth.phaseOffset_rad[i] + 0.05 * normal(random);
            tuned.gain[i] = truth.gain[i] * (1.0 + 0.03 * normal(random));
        }
        Eigen::Matrix3Xd at(3, 4);
        at << 0.01, 0.03, -0.025, 0.0, -0.02, 0.03, 0.01, 0.04, 0.12, 0.13, 0.11, 0.14;
        plan = planFor(truth, TuningMethod::SINGLE, at.leftCols(places));
        plate.position = {0.0, 0.0, 0.21};
        plate.normal = Eigen::Vector3d(0.014, -0.010, -1.0).normalized();
        plate.along = (Eigen::Vector3d::UnitX() - plate.normal.x() * plate.normal).normalized();
        plate.reflection = 0.8;
        plate.reflectionPhase_rad = 0.15;
        plate.accuracy_mm = 5.0;
        guess = plate;
        guess.position.z() += 0.0034;
        guess.normal = -Eigen::Vector3d::UnitZ();
        guess.along = Eigen::Vector3d::UnitX();
        guess.reflection = 1.0;
        guess.reflectionPhase_rad = 0.0;
    }

    /// The true pressures of all transducers, with the plate, by the array's mirror image.
    Eigen::MatrixXcd heardAt(const Eigen::Matrix3Xd& at, bool isThere = true) const
    {
        Eigen::MatrixXcd y = referencePropagationMatrix(at, truth, air);
        if (!isThere) return y;
        TransducerArray mirror = truth;
        const Eigen::Matrix3d turned =
            Eigen::Matrix3d::Identity() - 2.0 * plate.normal * plate.normal.transpose();
        mirror.positions =
            (turned * (truth.positions.colwise() - plate.position)).colwise() + plate.position;
        mirror.normals = turned * truth.normals;
        return y + std::polar(plate.reflection, plate.reflectionPhase_rad) *
                       referencePropagationMatrix(at, mirror, air);
    }

    TuningReadings readings(bool isThere = true)
    {
        std::normal_distribution<double> normal;
        Eigen::Matrix3Xd at = plan.places;
        for (double& coordinate : at.reshaped())
            coordinate += 2e-3 / std::sqrt(3.0) * normal(random);
        const Eigen::MatrixXcd heard = heardAt(at, isThere);
        TuningReadings read;
        read.values.resize(plan.size());
        for (int row = 0; row < plan.size(); ++row)
        {
            const TuningRow& planned = plan.rows[static_cast<std::size_t>(row)];
            const TuningDrive drive = driveOf(plan, planned, nullptr);
            std::complex<double> value = 0.0;
            for (std::size_t i = 0; i < drive.duty.size(); ++i)
                if (drive.duty[i] > 0)
                    value += heard(planned.place, static_cast<Eigen::Index>(i)) *
                             std::polar(1.0, base::kTwoPi * drive.phase[i] / 256.0);
            const double rms = heard.row(planned.place).norm() / std::sqrt(truth.size());
            value +=
                noise * rms * std::complex<double>(normal(random), normal(random)) / std::sqrt(2.0);
            read.values[row] = std::polar(1.0, 1.0 + planned.place) * value;
        }
        return read;
    }

    ReflectorFit fit(const TuningReadings& readings) const
    {
        return fitReflector(tuned, plan, readings, guess);
    }

    /// rms error of the true field at \a points of a drive for \a array.
    double errorOf(const TransducerArray& array, const ControlPoints& points) const
    {
        Eigen::VectorXcf q;
        makeSolver("gauss-newton")->solve(points, array, air, q);
        const Eigen::VectorXd y =
            (heardAt(points.positions) * q.cast<std::complex<double>>()).cwiseAbs();
        return relativeRms(y, points.targets, fittedLevel(y, points.targets));
    }
};

/// Returns the angle between the normals, degrees.
inline double tiltBetween(const Reflector& one, const Reflector& other)
{
    return base::toDegrees(std::acos(std::min(1.0, one.normal.dot(other.normal))));
}

} // namespace midair::haptics
