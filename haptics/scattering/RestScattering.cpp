#include "haptics/scattering/RestScattering.h"

#include "haptics/scattering/ScatteredField.h"
#include "haptics/scattering/ScatteringSolver.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/solvers/Solvers.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace midair::haptics
{

std::vector<Reflector> RestScattering::platesAmong(const std::vector<Reflector>& reflectors)
{
    std::vector<Reflector> plates;
    std::copy_if(reflectors.begin(),
                 reflectors.end(),
                 std::back_inserter(plates),
                 [](const Reflector& one) { return plateOf(one).has_value(); });
    return plates;
}

double RestScattering::cellsOf(const std::vector<Reflector>& plates, double wavelength_m)
{
    double cells = 0.0;
    for (const Reflector& one : plates)
        cells += ThinScreen::cellsOf(*plateOf(one), wavelength_m).prod();
    return cells;
}

void RestScattering::makeScreens(const std::vector<Reflector>& plates, double wavelength_m)
{
    if (plates == _plates && wavelength_m == _wavelength_m) return;
    _plates.clear();
    _screens.clear();
    for (const Reflector& one : plates)
        _screens.push_back(std::make_shared<ThinScreen>(*plateOf(one), wavelength_m));
    _plates = plates;
    _wavelength_m = wavelength_m;
}

FieldForPlates RestScattering::solve(const FieldBesidePlates& given)
{
    FieldForPlates solved;
    makeScreens(given.plates, given.medium.wavelength(given.array.frequency_Hz));
    TransducerArray alone = given.heard;
    const auto isPlate = [&](const Reflector& one)
    { return std::find(_plates.begin(), _plates.end(), one) != _plates.end(); };
    alone.reflectors.erase(
        std::remove_if(alone.reflectors.begin(), alone.reflectors.end(), isPlate),
        alone.reflectors.end());
    const auto truth = std::make_shared<ScatteredField>(
        _screens, std::move(alone), given.medium, given.options.threads, given.options.stop);

    // Its first solve makes the rows; a solver starts from multipliers only after one.
    auto solver = makeSolver(given.solver, given.options);
    Eigen::VectorXcf q;
    solver->solve(given.points, given.array, given.medium, q);
    if (!solver->startFrom(given.multipliers))
    {
        solved.why = "the solver can't go on from the playing field";
        return solved;
    }
    const auto told = [&](int round, double rms)
    {
        if (round == 0) solved.rmsBefore = rms;
    };
    ScatteringSolver correcting(std::move(solver), truth, told);
    solved.report = correcting.solve(given.points, given.array, given.medium, q);
    given.options.stop.throwIfRequested();
    if (!(solved.report.level_Pa > 0.0))
    {
        solved.why = solved.report.message.empty() ? "there is no field" : solved.report.message;
        return solved;
    }
    truth->setDrive(q);
    solved.outside = {truth->beyond_Pa(given.points.positions, given.heard), q};
    solved.highest_Pa =
        (truth->free_Pa(given.points.positions) + truth->scattered_Pa(given.points.positions))
            .cwiseAbs()
            .maxCoeff();
    solved.drive = std::move(q);
    return solved;
}

} // namespace midair::haptics
