#include "samples/tools/tune/ReadingJournal.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kSync_s = 0.5;

std::string lineOf(int row, std::complex<double> value, bool isLevel)
{
    const auto text = [](double number)
    { return std::isfinite(number) ? base::exactNumber(number) : std::string("nan"); };
    return isLevel ? fmt::format("{},{}\n", row, text(value.real()))
                   : fmt::format("{},{},{}\n", row, text(value.real()), text(value.imag()));
}

} // namespace

ReadingJournal::ReadingJournal(const std::string& path,
                               const haptics::TuningPlan& plan,
                               const std::string& planSum) :
    _path(path),
    _plan(plan),
    _sum(planSum),
    _file(path, "readings"),
    _found(haptics::readingsFromCsv(_file.text(), _path, _plan))
{
    if (_found.isTorn) _file.cutTornLine();
    if (_file.text().find('\n') == std::string::npos)
        write(fmt::format("# plan {}\n", _sum));
    else if (_found.planSum != _sum)
        throw base::InputError(fmt::format(
            "readings \"{}\" belong to {}, this plan is {}; take another file with --out",
            _path,
            _found.planSum.empty() ? "no plan that they name" : "plan " + _found.planSum,
            _sum));
}

bool ReadingJournal::isRead(int row) const
{
    return std::isfinite(_found.values[row].real());
}

void ReadingJournal::write(const std::string& text)
{
    _file.append(text);
    const double now_s = base::steadySeconds();
    if (now_s - _synced_s < kSync_s) return;
    _file.sync();
    _synced_s = now_s;
}

void ReadingJournal::append(int row, std::complex<double> value, bool isLevel)
{
    write(lineOf(row, value, isLevel));
    _found.values[row] = value;
    _found.areLevels = isLevel;
}

void ReadingJournal::forget(int place)
{
    std::error_code error;
    std::filesystem::copy_file(
        _path, _path + ".old", std::filesystem::copy_options::overwrite_existing, error);
    if (error)
        throw base::InputError("readings \"" + _path + "\" can't be copied to \"" + _path +
                               ".old\": " + error.message());
    std::string text = fmt::format("# plan {}\n", _sum);
    for (int row = 0; row < _plan.size(); ++row)
    {
        if (_plan.rows[static_cast<std::size_t>(row)].place == place)
            _found.values[row] = {std::nan(""), 0.0};
        else if (isRead(row))
            text += lineOf(row, _found.values[row], _found.areLevels);
    }
    _file.replace(text);
}

} // namespace midair::samples
