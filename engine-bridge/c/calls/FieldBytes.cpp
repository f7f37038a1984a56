// midair_field_bytes() and midair_field_from_bytes(): serialized fields.
#include "engine-bridge/c/inside/Field.h"
#include "haptics/base/InputError.h"

#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

using namespace midair;
using namespace midair::capi;

namespace
{

using Json = nlohmann::json;

/// Version of the bytes; other versions are refused.
constexpr int kFormat = MIDAIR_VERSION / 100;

// --- Numbers, as they lie in memory --------------------------------------------------------------

template<typename T>
Json bytesOf(const T* numbers, std::size_t count)
{
    std::vector<std::uint8_t> bytes(count * sizeof(T));
    if (count > 0) std::memcpy(bytes.data(), numbers, bytes.size());
    return Json::binary(std::move(bytes));
}

template<typename Numbers>
Json bytesOf(const Numbers& numbers)
{
    return bytesOf(numbers.data(), static_cast<std::size_t>(numbers.size()));
}

template<typename T>
std::vector<T> numbersOf(const Json& json)
{
    const std::vector<std::uint8_t>& bytes = json.get_binary();
    if (bytes.size() % sizeof(T) != 0) throw base::InputError("a list of numbers is cut off");
    std::vector<T> numbers(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

/// Reads columns of \a rows numbers; fails unless there are \a columns (any number if below 0).
template<typename Matrix>
Matrix matrixOf(const Json& json, Eigen::Index columns, Eigen::Index rows = 1)
{
    using Scalar = typename Matrix::Scalar;
    const std::vector<Scalar> all = numbersOf<Scalar>(json);
    const auto count = static_cast<Eigen::Index>(all.size());
    if (count % rows != 0 || (columns >= 0 && count != rows * columns))
        throw base::InputError("the lengths of its lists don't match");
    const bool isVector = Matrix::ColsAtCompileTime == 1;
    return Eigen::Map<const Matrix>(
        all.data(), isVector ? count : rows, isVector ? 1 : count / rows);
}

// --- What a field is made of ---------------------------------------------------------------------

Json bytesOfArray(const haptics::TransducerArray& array, const haptics::DriveResolution& drive)
{
    return {{"name", array.name},
            {"frequency", array.frequency_Hz},
            {"source", array.sourceAmplitude_Pa_m},
            {"exposure", array.exposureAmplitude_Pa_m},
            {"directivity", haptics::directivityName(array.directivity)},
            {"ringing", array.ringing_s},
            {"positions", bytesOf(array.positions)},
            {"normals", bytesOf(array.normals)},
            {"phaseOffset", bytesOf(array.phaseOffset_rad)},
            {"gain", bytesOf(array.gain)},
            {"board", bytesOf(array.board)},
            {"dead", bytesOf(array.dead)},
            {"reflectors", haptics::reflectorsToJson(array.reflectors)},
            {"phaseLevels", drive.phaseLevels},
            {"amplitudeLevels", bytesOf(drive.amplitudeLevels)}};
}

/// Uses the field's drive, because the array's own is no longer needed.
haptics::TransducerArray arrayOf(const Json& json)
{
    haptics::TransducerArray array;
    array.name = json.at("name");
    array.frequency_Hz = json.at("frequency");
    array.sourceAmplitude_Pa_m = json.at("source");
    array.exposureAmplitude_Pa_m = json.at("exposure");
    array.directivity = haptics::directivityFromName(json.at("directivity"));
    array.ringing_s = json.at("ringing");
    array.positions = matrixOf<Eigen::Matrix3Xd>(json.at("positions"), -1, 3);
    array.normals = matrixOf<Eigen::Matrix3Xd>(json.at("normals"), -1, 3);
    array.phaseOffset_rad = matrixOf<Eigen::VectorXd>(json.at("phaseOffset"), -1);
    array.gain = matrixOf<Eigen::VectorXd>(json.at("gain"), -1);
    array.board = numbersOf<int>(json.at("board"));
    array.dead = numbersOf<int>(json.at("dead"));
    const std::string reflectors = json.at("reflectors");
    array.reflectors =
        haptics::reflectorsFromJson("{\"reflectors\": " + reflectors + "}", "its array");
    array.drive.phaseLevels = json.at("phaseLevels");
    array.drive.amplitudeLevels = numbersOf<float>(json.at("amplitudeLevels"));
    std::string why;
    if (!array.isValid(&why)) throw base::InputError("its array: " + why);
    return array;
}

Json bytesOfReport(const haptics::SolveReport& report)
{
    std::vector<double> figures;
    const auto add = [&](const auto& rows, const auto& record)
    {
        for (const auto& row : rows)
            std::visit([&](auto member) { figures.push_back(static_cast<double>(record.*member)); },
                       row.value);
    };
    add(haptics::kFigures, report);
    add(haptics::kSurfaceFigures, report.surface);
    return {{"solver", report.solver},
            {"stop", static_cast<int>(report.stop)},
            {"message", report.message},
            {"figures", bytesOf(figures)}};
}

haptics::SolveReport reportOf(const Json& json)
{
    haptics::SolveReport report;
    report.solver = json.at("solver");
    report.message = json.at("message");
    const int stop = json.at("stop");
    if (stop < 0 || stop > static_cast<int>(haptics::StopReason::SILENCED))
        throw base::InputError("its reason for stopping is invalid");
    report.stop = static_cast<haptics::StopReason>(stop);
    const std::vector<double> figures = numbersOf<double>(json.at("figures"));
    if (figures.size() != std::size(haptics::kFigures) + std::size(haptics::kSurfaceFigures))
        throw base::InputError("its figures are not those of this version");
    std::size_t next = 0;
    const auto take = [&](const auto& rows, auto& record)
    {
        for (const auto& row : rows)
            std::visit(
                [&](auto member)
                {
                    using Value = std::decay_t<decltype(record.*member)>;
                    const double value = figures[next++];
                    if constexpr (std::is_integral_v<Value>)
                        record.*member = std::abs(value) <= std::numeric_limits<int>::max()
                                             ? static_cast<Value>(value)
                                             : Value{};
                    else
                        record.*member = static_cast<Value>(value);
                },
                row.value);
    };
    take(haptics::kFigures, report);
    take(haptics::kSurfaceFigures, report.surface);
    return report;
}

Json bytesOfPoints(const Field& field)
{
    std::vector<int> parts;
    for (const haptics::ControlPoints& part : field.sequence.parts)
        parts.push_back(part.size());
    return {{"positions", bytesOf(field.points.positions)},
            {"normals", bytesOf(field.points.normals)},
            {"targets", bytesOf(field.points.targets)},
            {"absolute", field.points.absolute},
            {"object", bytesOf(field.points.object)},
            {"objects", bytesOf(field.objects)},
            {"wanted", bytesOf(field.wanted_Pa)},
            {"achieved", bytesOf(field.achieved_Pa)},
            {"parts", bytesOf(parts)}};
}

void takePoints(const Json& json, Field& field)
{
    haptics::ControlPoints& points = field.points;
    points.positions = matrixOf<Eigen::Matrix3Xd>(json.at("positions"), -1, 3);
    const Eigen::Index n = points.size();
    points.normals = matrixOf<Eigen::Matrix3Xd>(json.at("normals"), -1, 3);
    points.targets = matrixOf<Eigen::VectorXd>(json.at("targets"), n);
    points.absolute = json.at("absolute");
    points.object = numbersOf<int>(json.at("object"));
    field.objects = numbersOf<midair_object>(json.at("objects"));
    field.wanted_Pa = matrixOf<Eigen::VectorXd>(json.at("wanted"), n);
    field.achieved_Pa = matrixOf<Eigen::VectorXd>(json.at("achieved"), n);
    Eigen::Index done = 0;
    for (const int size : numbersOf<int>(json.at("parts")))
    {
        if (size < 0 || size > n - done)
            throw base::InputError("its fields' numbers of points don't match");
        field.sequence.parts.emplace_back().positions = points.positions.middleCols(done, size);
        done += size;
    }
    const bool goTogether = (points.normals.cols() == 0 || points.normals.cols() == n) &&
                            (points.object.empty() || points.object.size() == std::size_t(n)) &&
                            points.positions.allFinite();
    if (!goTogether) throw base::InputError("the sizes of its points don't match");
}

Json bytesOfFields(const Field& field)
{
    Json all = Json::array();
    for (std::size_t k = 0; k < field.sequence.fields.size(); ++k)
        all.push_back({{"activations", bytesOf(field.sequence.fields[k])},
                       {"phase", bytesOf(field.signals[k].phase)},
                       {"duty", bytesOf(field.signals[k].duty)}});
    return all;
}

void takeFields(const Json& json, Field& field)
{
    const Eigen::Index m = field.array->size();
    for (const Json& one : json)
    {
        const auto& q = field.sequence.fields.emplace_back(
            matrixOf<Eigen::VectorXcf>(one.at("activations"), m));
        device::DriveSignal& signal = field.signals.emplace_back();
        signal.phase = numbersOf<std::uint8_t>(one.at("phase"));
        signal.duty = numbersOf<std::uint8_t>(one.at("duty"));
        if (!signal.fits(static_cast<int>(m)) || !q.allFinite() || q.cwiseAbs().maxCoeff() > 1.001F)
            throw base::InputError("its drives don't match its transducers");
    }
    if (field.sequence.fields.empty() || field.sequence.parts.size() > field.sequence.fields.size())
        throw base::InputError("it has too few fields");
}

Json jsonOf(const Field& field)
{
    const haptics::Medium& air = field.medium;
    const haptics::FingertipForce felt = field.fingertip();
    return {
        {"midair_field", kFormat},
        {"array", bytesOfArray(*field.array, field.drive)},
        {"air", {air.temperature_C, air.relativeHumidity, air.pressure_Pa}},
        {"points", bytesOfPoints(field)},
        {"fields", bytesOfFields(field)},
        {"rate", field.sequence.modulation.fieldRate_Hz},
        {"evened", field.sequence.evened},
        {"report", bytesOfReport(field.sequence.report)},
        {"ears", bytesOf(field.ears)},
        {"earLimit", field.earLimit_dB},
        {"felt", {felt.force_N, felt.alternating_N, static_cast<int>(felt.how), felt.threshold_N}},
        {"frame", field.info.frame},
        {"playing", field.info.playing},
        {"latency", field.info.latency_ms}};
}

haptics::FingertipForce feltOf(const Json& json)
{
    const int how = json.at(2);
    const haptics::FingertipForce felt{
        json.at(0), json.at(1), static_cast<haptics::PlayedAs>(how), json.at(3)};
    if (!std::isfinite(felt.force_N) || !std::isfinite(felt.alternating_N) ||
        !std::isfinite(felt.threshold_N) || how < 0 ||
        how > static_cast<int>(haptics::PlayedAs::CIRCLING))
        throw base::InputError("its fingertip force is invalid");
    return felt;
}

std::shared_ptr<Field> fieldFrom(const Json& json)
{
    if (json.at("midair_field") != kFormat)
        throw base::InputError("it was written by another version");
    auto field = std::make_shared<Field>();
    const auto array = std::make_shared<haptics::TransducerArray>(arrayOf(json.at("array")));
    field->drive = array->drive;
    field->array = array;
    const Json& air = json.at("air");
    field->medium = {air.at(0), air.at(1), air.at(2)};
    std::string why;
    if (!field->medium.isValid(&why)) throw base::InputError("its air: " + why);
    takePoints(json.at("points"), *field);
    takeFields(json.at("fields"), *field);
    field->sequence.modulation.fieldRate_Hz = json.at("rate");
    if (!field->sequence.modulation.isValid(&why)) throw base::InputError(why);
    field->sequence.evened = json.at("evened");
    field->sequence.report = reportOf(json.at("report"));
    field->ears = matrixOf<Eigen::Matrix3Xd>(json.at("ears"), -1, 3);
    if (!field->ears.allFinite()) throw base::InputError("its ears are not finite");
    field->earLimit_dB = json.at("earLimit");
    field->felt = feltOf(json.at("felt"));
    field->complete();
    field->info.frame = json.at("frame");
    field->info.playing = json.at("playing");
    field->info.latency_ms = json.at("latency");
    return field;
}

} // namespace

midair_status
midair_field_bytes(const midair_field* field, void* bytes, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const std::vector<std::uint8_t> all = Json::to_cbor(jsonOf(*fields().find(field)));
            if (needed) *needed = all.size();
            if (size == 0 && needed) return;
            if (!bytes) fail(MIDAIR_INVALID, "bytes is NULL");
            if (size < all.size())
                fail(MIDAIR_TOO_SMALL,
                     fmt::format("the field takes {} bytes, there are {}", all.size(), size));
            std::memcpy(bytes, all.data(), all.size());
        });
}

midair_status midair_field_from_bytes(const void* bytes, size_t size, midair_field** field)
{
    return called(
        [&]
        {
            given(field, "field");
            if (!bytes) fail(MIDAIR_INVALID, "bytes is NULL");
            const auto* const first = static_cast<const std::uint8_t*>(bytes);
            std::shared_ptr<Field> made;
            try
            {
                made = fieldFrom(Json::from_cbor(first, first + size));
            }
            catch (const Json::exception&)
            {
                fail(MIDAIR_REFUSED, "the bytes are not those of a field");
            }
            catch (const base::InputError& error)
            {
                fail(MIDAIR_REFUSED,
                     std::string("the bytes are not those of a field: ") + error.what());
            }
            *field = fields().add(made);
            return soundsOrWhy(*made);
        });
}
