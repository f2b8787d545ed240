"""The kinds of cases: each a function that draws one from a random generator and a place."""

import shutil

import yaml
from helpers.parameter_calls import DECLARED

from hostile.case import Case
from hostile.contents import odd_path, odd_yaml, spoilt_bag, spoilt_journal, spoilt_text
from hostile.foreign_code import odd_plugin
from hostile.words import odd_name, odd_number

NODES = tuple(DECLARED)
PARAMETERS = [f'{node}.{name}' for node, declared in DECLARED.items() for name in declared]


def _sound(command, place):
    """Return arguments with which a command does little and succeeds, without its output."""
    return {
        'simulate': ['--duration', '0.02'],
        'experiment': ['--duration', '0.02', '--composed', '--no-report', '-p', 'plant.real_time_factor:=0.0'],
        'report': [str(place.samples / 'run.csv')],
        'tune': ['velocity', '--seed', '1', '--generations', '1', '--population', '5', '--workers', '1', '--laps',
                 '0.01'],
        'study': ['--runs', '1', '--seed', '1', '--laps', '0.01', '--workers', '1'],
    }[command]


def output_of(command, place):
    """Return the option of a command's output."""
    name = {'simulate': 'run.csv', 'tune': 'gains.yaml'}.get(command, 'folder')
    return ['--output', str(place.out / name)]


def _case(draw, command, place, odd, named, **rest):
    """Make a case of a command's sound arguments and odd ones."""
    if command in NODES:
        return Case(command, ['--ros-args', *odd], named, **rest)
    return Case(command, [*_sound(command, place), *output_of(command, place), *odd], named, **rest)


def _ros(command, override):
    """Write an override as the command takes it: the nodes take no name of a node before a dot."""
    return override.partition('.')[2] if command in NODES else override


_COMMANDS = ('simulate', 'simulate', 'study', 'tune', 'report', 'experiment', *NODES)


def names(draw, place):  # noqa: PLR0911 (one for each form)
    """Draw an odd name of a parameter, a node, a law, a curve, a robot, a gain or a run."""
    form = draw.choice(
        ('parameter', 'parameter', 'override', 'law', 'curve', 'robot', 'searched', 'bounds', 'keep', 'run', 'option'))
    if form in ('parameter', 'override'):
        command = draw.choice(_COMMANDS)
        sound = draw.choice(PARAMETERS)
        name = odd_name(draw, sound)
        value = draw.choice(('1.0', '1', 'x', odd_name(draw)))
        text = f'{name}:={value}' if form == 'parameter' else odd_name(draw, f'{sound}:=1.0')
        # a sound name may have lost a part of its value: the name is told, with the number that was read
        told = text.partition(':=')[0].rpartition('.')[2] or text
        return _case(draw, command, place, ['-p', text], (text, name, value, name.rpartition('.')[2],
                                                          text.partition('.')[2], told, '-p'))
    if form in ('law', 'curve'):
        where = 'position_controller.controller_type' if form == 'law' else 'reference_cart.curve'
        name = odd_name(draw, 'backstepping' if form == 'law' else 'trifolium')
        if form == 'curve' and draw.random() < 0.4:
            return _case(draw, draw.choice(('study', 'tune')), place, ['--curves', name], (name, '--curves'))
        return _case(draw, draw.choice(('simulate', 'study', 'experiment')), place, ['-p', f'{where}:={name}'],
                     (name, where, where.partition('.')[2]))
    if form == 'robot':
        name = odd_name(draw, 'chapter')
        return _case(draw, draw.choice(('simulate', 'study', 'tune', 'report', 'experiment')), place,
                     [f'--robot={name}'], (name, '--robot'))
    if form == 'run':
        name = odd_name(draw)
        if draw.random() < 0.5:
            return Case('report', [f'{name}={place.samples}/run.csv', *output_of('report', place)], (name, 'report: '))
        file = place.here / f'a{name}'.replace('/', '_')[:60]
        shutil.copyfile(place.samples / 'run.csv', file)
        return Case('report', [str(file), *output_of('report', place)], (str(file), 'report: '))
    name = odd_name(draw, 'k1')
    if form == 'searched':
        return Case('tune', [name, *_sound('tune', place)[1:], *output_of('tune', place)],
                    (name, 'controller', 'arguments'))
    if form == 'option':
        return _case(draw, draw.choice(('simulate', 'experiment', 'report', 'tune', 'study')), place, [f'--{name}'],
                     (name, f'--{name}', 'arguments', 'options', f"'--{name}'", 'usage: '))
    text = f'{name}={odd_number(draw)}:{odd_number(draw)}' if form == 'bounds' else name
    return Case('tune', ['backstepping', *_sound('tune', place)[1:], f'--{form}={text}', *output_of('tune', place)],
                (name, text, f'--{form}', 'stand', *text.partition('=')[2].split(':')))


_NUMERIC = {
    'simulate': ['--duration'], 'experiment': ['--patience', '--duration'],
    'tune': ['--seed', '--population', '--generations', '--time-limit', '--laps', '--scales', '--mass', '--friction',
             '--delays', '--coulomb', '--random', '--variation', '--within', '--scenario-seed', '--start', '--workers'],
    'study': ['--runs', '--seed', '--laps', '--scales', '--within', '--variation', '--noise-pose', '--noise-velocity',
              '--longest-delay', '--workers'],
}


def numbers(draw, place):
    """Draw an odd number for an option or a parameter."""
    value = odd_number(draw)
    if draw.random() < 0.5:
        command = draw.choice(list(_NUMERIC))
        option = draw.choice(_NUMERIC[command])
        value += ',0,0' if option == '--start' else ''
        odd = [option, value, value, value] if option == '--noise-pose' else [f'{option}={value}']
        if option == '--duration' and command == 'experiment':
            odd += ['--patience', '1']
        return _case(draw, command, place, odd, (value, option, 'expected'))
    command = draw.choice(('simulate', 'simulate', 'simulate', 'study', 'tune', 'report', *NODES))
    parameter = draw.choice([name for name in PARAMETERS if command not in NODES or name.startswith(command)])
    if draw.random() < 0.3:
        value = str([value] * draw.choice((1, 3, 5))).replace("'", '')
    return _case(draw, command, place, ['-p', f'{_ros(command, parameter)}:={value}'],
                 (value, parameter, parameter.partition('.')[2], *value.strip('[]').split(', ')))


def files(draw, place):  # noqa: PLR0911 (one for each form)
    """Draw an odd file to read, or an odd place to write to."""
    form = draw.choice(('params', 'params', 'robot', 'law', 'curve', 'table', 'table', 'bag', 'bag', 'run', 'journal',
                        'output', 'output', 'compare', 'gone', 'standing'))
    if form in ('params', 'robot', 'law', 'curve'):
        option = {'params': '--params-file', 'robot': '--robot', 'law': '--law', 'curve': '--curve'}[form]
        nodes = NODES if form == 'params' else ()
        command = draw.choice(('simulate', 'study', 'tune', 'experiment', 'report', *nodes))
        path = odd_path(draw, place, 'file.yaml' if form in ('params', 'robot') else 'file.py')
        return _case(draw, command, place, [option, path], (path, option))
    if form in ('table', 'bag', 'run'):
        if form == 'table':
            path = str(place.here / 'run.csv')
            for beside in place.samples.glob('run.*'):
                shutil.copyfile(beside, place.here / beside.name)
            spoilt = draw.choice(sorted(place.here.iterdir()))
            spoilt.write_bytes(spoilt_text(draw, spoilt.read_text()))
        else:
            path = spoilt_bag(draw, place) if form == 'bag' else odd_path(draw, place, 'run')
        return Case('report', [path, *draw.choice(([], [str(place.samples / 'run.csv')])), *output_of('report', place)],
                    (path,), seconds=30.0)
    if form == 'journal':
        output = spoilt_journal(draw, place)
        return Case('tune', [*_sound('tune', place), '--output', output, '--resume'], (output,))
    if form == 'standing':
        command = draw.choice(('simulate', 'tune', 'study', 'experiment', 'report'))
        arguments = output_of(command, place)
        path = place.out / arguments[1]
        path.write_bytes(spoilt_text(draw, (place.samples / 'parameters.yaml').read_text()))
        return Case(command, [*_sound(command, place), *arguments,
                              *draw.choice(([], ['--overwrite']))[:command in ('tune', 'study')]],
                    (str(path), str(place.out)))
    command = draw.choice(('simulate', 'study', 'tune', 'report', 'experiment'))
    if form == 'compare':
        path = odd_path(draw, place, 'c.yaml')
        return _case(draw, draw.choice(('study', 'experiment')), place, ['--compare', path, *draw.choice(([], [path]))],
                     (path, '--compare'))
    if form == 'gone':
        return Case(command, [*_sound(command, place), '--output', 'below'], ('below', 'folder', 'directory'),
                    gone=True)
    path = draw.choice((str(place.out), *_unwritable(place)))
    return Case(command, [*_sound(command, place), '--output', path], (path,))


def _unwritable(place):
    file = place.here / 'file'
    file.write_text('')
    loop = place.here / 'loop'
    loop.symlink_to('loop')
    return ('/dev/full', '/dev/null', '/proc/x', '/', '/proc/self/mem', f'{file}/x', str(loop), f'{loop}/x',
            str(place.out / ('a' * 300)), str(place.out / ('a/' * 2500)), '/sys/x', '/dev/stdin/x')


def namespaces(draw, place):
    """Draw an odd namespace."""
    name = odd_name(draw, '/robot1/arm_2')
    if draw.random() < 0.4:
        name = '/' + name
    command = draw.choice(('report', 'experiment', *NODES))
    if command in NODES:
        word = draw.choice(('__ns', '__ns', '__node', 'odom', '/odom', 'plant:__ns', odd_name(draw)))
        return _case(draw, command, place, ['-r', f'{word}:={name}'], (name, word, '-r'))
    return _case(draw, command, place, [f'--namespace={name}'], (name, '--namespace'))


def texts(draw, place):
    """Draw a parameter file that is nearly right."""
    file = place.here / 'p.yaml'
    sound = (place.samples / 'parameters.yaml').read_text()
    if draw.random() < 0.4:
        node, parameter = draw.choice(PARAMETERS).split('.', 1)
        section = draw.choice((node, f'/{node}', f'/**/{node}', '/**', odd_name(draw)))
        value = draw.choice((odd_number(draw), odd_name(draw)))
        sound = f'{section}:\n  ros__parameters:\n    {parameter}: {value}\n'
    text = odd_yaml(draw, sound)
    file.write_bytes(spoilt_text(draw, text) if draw.random() < 0.3 else text.encode(errors='surrogateescape'))
    command = draw.choice(('simulate', 'simulate', 'simulate', 'study', 'tune', 'report', *NODES))
    return _case(draw, command, place, ['--params-file', str(file)], (str(file), 'no longer', *_declared_in(file)))


def _declared_in(file):
    """List the names and values of a file, of which a refusal of what they add up to names one."""
    try:
        words = [getattr(event, 'value', '') or '' for event in yaml.parse(file.read_bytes())]
        return [str(word) for word in words if len(word) > 2]
    except (yaml.YAMLError, ValueError, RecursionError):
        return []


def plugins(draw, place):
    """Draw a law or a curve from a file, an environment variable or an entry point."""
    kind = draw.choice(('law', 'law', 'curve'))
    path, name = odd_plugin(draw, place, kind)
    named = (path, name, f'--{kind}', 'LAW' if kind == 'law' else 'CURVE', 'controller_type = ', 'curve = ')
    chosen = ['-p', f'{"position_controller.controller_type" if kind == "law" else "reference_cart.curve"}:={name}']
    command = draw.choice(('simulate', 'simulate', 'simulate', 'simulate', 'study', 'tune', 'experiment'))
    way = draw.choice(('file', 'file', 'file', 'variable', 'entry point'))
    if way == 'file':
        odd, environment = [f'--{kind}={path}', *draw.choice((chosen, chosen, chosen, []))], {}
    elif way == 'variable':
        value = draw.choice((path, f':{path}:', f'{path}:{path}', odd_name(draw)))
        odd, environment = chosen, {f'MOBILE_ROBOT_CONTROL_{kind.upper()}S': value}
    else:
        # the current folder is where Python looks for modules and what they are installed with
        installed = place.here / 'odd-1.0.dist-info'
        installed.mkdir()
        (installed / 'METADATA').write_text('Metadata-Version: 2.1\nName: odd\nVersion: 1.0\n')
        target = draw.choice(
            (f'own:{kind.upper()}', 'own', 'absent:LAW', 'own:absent.x', odd_name(draw), ':', 'os:environ'))
        point = f'[mobile_robot_control.{kind}s]\nown = {target}\n'
        (installed / 'entry_points.txt').write_bytes(
            spoilt_text(draw, point) if draw.random() < 0.3 else point.encode(errors='replace'))
        odd, environment = chosen, {'PYTHONPATH': f'{place.here}'}
    if command == 'tune' and kind == 'law' and draw.random() < 0.7:
        return Case('tune', [*odd, name, *_sound('tune', place)[1:], *output_of('tune', place)], (*named, 'controller'),
                    environment, cold=bool(environment))
    return _case(draw, command, place, odd, named, environment=environment, cold=bool(environment))


VARIABLES = {
    'MPLBACKEND': ['x', '', 'tkagg', 'module://x'], 'MPLCONFIGDIR': ['/dev/null', '/proc/x'], 'TQDM_MININTERVAL': ['x'],
    'TQDM_DISABLE': ['1'], 'TQDM_NCOLS': ['x'], 'COLUMNS': ['x', '0', '-1', '9' * 30], 'LINES': ['x'],
    'TERM': ['', 'x'], 'LANG': ['C', 'x'], 'LC_ALL': ['C', 'POSIX', 'tr_TR.UTF-8'],
    'PYTHONIOENCODING': ['ascii', 'latin-1', 'utf-16'], 'PYTHONUTF8': ['0', '1'], 'PYTHONOPTIMIZE': ['2'],
    'PYTHONWARNINGS': ['error', 'x'], 'PYTHONDEVMODE': ['1'], 'PYTHONSAFEPATH': ['1'], 'PYTHONINTMAXSTRDIGITS': ['0'],
    'HOME': [None, '', '/dev/null', '/', '\udcff'], 'TMPDIR': ['/dev/null', '', '/absent'], 'TZ': ['x'],
    'PATH': [None, ''], 'NUMBA_DISABLE_JIT': ['1', 'x'], 'NUMBA_NUM_THREADS': ['x', '0', '9999'],
    'NUMBA_CACHE_DIR': ['/dev/null'], 'OMP_NUM_THREADS': ['x', '0'], 'OPENBLAS_NUM_THREADS': ['x', '-1'],
    'SOURCE_DATE_EPOCH': ['x', '-1', '9' * 30], 'ROS_DOMAIN_ID': ['', 'x', '233', '-1', '1e2', ' 231', '9' * 30],
    'RMW_IMPLEMENTATION': ['x', '', 'rmw_x_cpp', '\udcff'], 'ROS_LOG_DIR': ['/dev/null', '/proc/x', '~', 'a\nb'],
    'ROS_HOME': ['/dev/null'], 'ROS_AUTOMATIC_DISCOVERY_RANGE': ['x', '', 'OFF'],
    'ROS_STATIC_PEERS': ['x', ';;', '::1', 'a' * 300], 'ROS_DISTRO': ['x'], 'ROS_SECURITY_ENABLE': ['true'],
    'ROS_SECURITY_ENCLAVE_OVERRIDE': ['x'], 'FASTDDS_DEFAULT_PROFILES_FILE': ['/absent', '/dev/null', '/'],
    'RMW_FASTRTPS_USE_QOS_FROM_XML': ['x'], 'RMW_FASTRTPS_PUBLICATION_MODE': ['x'],
    'RCUTILS_COLORIZED_OUTPUT': ['x', '2'], 'RCUTILS_LOGGING_USE_STDOUT': ['x', '1'],
    'RCUTILS_LOGGING_BUFFERED_STREAM': ['x'], 'RCUTILS_CONSOLE_OUTPUT_FORMAT': ['{', '{x}', '', '%s' * 100],
    'AMENT_PREFIX_PATH': ['/absent', '::', '\n'],
    'MOBILE_ROBOT_CONTROL_LAWS': ['/absent', ':', '/dev/zero', '\udcff', '.'],
    'MOBILE_ROBOT_CONTROL_CURVES': ['/absent', '/dev/zero', '/'],
}


def environment(draw, place):
    """Draw odd environment variables, for a process."""
    names_drawn = draw.sample(list(VARIABLES), draw.choice((1, 1, 1, 2)))
    changes = {name: draw.choice(VARIABLES[name]) for name in names_drawn}
    command = draw.choice(('simulate', 'simulate', 'report', 'study', 'plant', 'experiment', 'tune'))
    values = [value for value in changes.values() if value]
    # a node goes on until it is interrupted
    return _case(draw, command, place, [], (*names_drawn, *values), environment=changes, process=True,
                 seconds=3.0 if command in NODES else 60.0)


KINDS = {kind.__name__: kind for kind in (names, numbers, files, namespaces, texts, plugins, environment)}
"""By name, which the seed of a case begins with."""
