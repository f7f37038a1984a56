// Without a scene graph, on libmidair alone: solves for one point above a board, plays it in the
// simulator and prints the pressure.

#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/solvers/HologramSolver.h"

#include <chrono>
#include <complex>
#include <cstdio>
#include <thread>
#include <vector>

using namespace midair;

int main()
{
    const haptics::TransducerArray array = haptics::TransducerArray::load("board");
    const haptics::Medium air; // 20 degrees Celsius
    haptics::ControlPoints points;
    points.positions = Eigen::Vector3d(0.0, 0.0, 0.15); // m, above the centre of the board
    points.normals = Eigen::Vector3d::UnitZ();
    points.targets = Eigen::VectorXd::Ones(1);
    Eigen::VectorXcf q;
    const auto solver = haptics::makeSolver(haptics::solverNames().front(), {});
    const haptics::SolveReport report = solver->solve(points, array, air, q);

    // A real array needs limits here, e.g. "usb:?max-amplitude=0.2".
    const auto device = device::openDevice("sim:", {array.size(), array.board});
    device::DriveSignal signal;
    device::encode(q.data(), static_cast<int>(q.size()), signal);
    device->send(signal);
    double heard_Pa = 0.0;
    for (int i = 0; i < 1000 && heard_Pa == 0.0; ++i)
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        std::vector<std::complex<float>> played = device->played();
        if (played.size() != static_cast<std::size_t>(array.size())) continue;
        const Eigen::VectorXcf now = Eigen::Map<Eigen::VectorXcf>(played.data(), array.size());
        heard_Pa = std::abs(haptics::pressureAt(points.positions, array, air, now, 1)[0]);
    }
    std::printf("%d transducers: %.0f Pa solved for, %.0f Pa played\n",
                array.size(),
                report.level_Pa,
                heard_Pa);
    return heard_Pa > 0.98 * report.level_Pa && heard_Pa < 1.02 * report.level_Pa ? 0 : 1;
}
