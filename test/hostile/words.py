"""Odd names and numbers."""

NAMES = ['', ' ', '.', '..', '/', '//', '~', '-', '--', '-x', '=', ':=', ':', ',', '#', '*', '/**', '%s', '%n', '{}',
         '{0.__class__}', '$HOME', '$(id)', '`id`', '${jndi:x}', "';--", '"', "'", '\\', '\\n', '\n', 'one\ntwo', '\t',
         '\r', '\x1b[31m', '\x1b]0;x\x07', '\x7f', '\x80', '\xa0', '\udcff', 'a\udc80b', '\u2028', '\u202e', '\ufeff',
         '\ufffe', 'é', 'e\u0301', 'ß', 'İ', '٣', '²', '½', 'ﬁ', '機', '🤖', '𝟙', '<script>', '<b>&amp;', ']]>',
         '__class__', '__init__', 'os.system', 'os', 'None', 'null', 'true', 'nan', 'NaN', 'self', 'con', 'lost+found',
         'A', 'A' * 300, 'a' * 5000, 'a/' * 50, '../' * 20 + 'etc', '/etc/passwd', '/dev/null', 'a b', 'a.b', 'a..b',
         'a.', '.a', '0', '1a', 'a-b', 'a=b', 'gains', 'gains.', 'fuzzy', 'fuzzy.b', 'fuzzy.b[1]', 'fuzzy.b[9]',
         'fuzzy.b[-1]', 'fuzzy.b[1e9]', 'k1', 'plant', 'plant.', 'limits', 'velocity', 'trifolium', 'Trifolium',
         'backstepping ', 'position_controller.backstepping.k1', 'use_sim_time',
         'qos_overrides./clock.subscription.depth', 'ros__parameters', '$_{', '\\frac{', '$x^$', '_hidden', '=cmd|0',
         '@x', '!x', 'tcp://x']
NUMBERS = ['0', '-0', '-0.0', '1', '-1', '1.', '.1', '1e-3', '1e-9', '1e-12', '1e-13', '5e-324', '2.2e-308', '1e12',
           '1.0000001e12', '1e17', '1e300', '1.7976931348623157e308', '1e309', '-1e309', 'nan', '.nan', '-nan', 'inf',
           '-inf', '.inf', 'Infinity', '0x10', '0b11', '0o17', '010', '1_000', '1,5', '1:40', '1e', 'e1', '--5', '+5',
           '5-', '1/2', '1 2', ' 1', '1\n', '٣', '²', '１', '½', '2147483647', '2147483648', '-2147483649',
           '9223372036854775807', '9223372036854775808', '18446744073709551616', '9' * 400, '9' * 5000,
           '0.' + '0' * 400 + '1', '1e' + '9' * 30, '1e-' + '9' * 30, 'true', 'false', 'yes', 'null', '~', '[]',
           '[1.0]', '[1.0, 2.0, 3.0]', '[[1.0]]', '[nan, 0.0, 0.0]', '[1, "a", 2]', '{}', '{a: 1}',
           '!!python/object/apply:os.system [id]', '&a [*a]', '*a', '!x 1', '2026-11-22', '1.5.2', '0.5', '2', '100',
           '500', '1000', '1000.0', '123.456', '3.3333333333333335']


def mangled(draw, text):
    """Change a text in one place: leave out, double, replace or insert."""
    place = draw.randrange(len(text) + 1)
    end = place + draw.choice((0, 0, 1, 1, 2, 5))
    filling = draw.choice(('', '', text[place:end] * 2, draw.choice(NAMES), draw.choice(NUMBERS),
                           chr(draw.randrange(1, 0x300))))
    return text[:place] + filling + text[end:]


def odd_name(draw, sound=''):
    """Draw an odd name, at times one that is close to a sound one."""
    if sound and draw.random() < 0.4:
        return mangled(draw, sound)
    name = draw.choice(NAMES)
    return name + draw.choice(NAMES) if draw.random() < 0.1 else name


def odd_number(draw):
    """Draw an odd number, or what is none."""
    chance = draw.random()
    if chance < 0.7:
        return draw.choice(NUMBERS)
    if chance < 0.8:
        return mangled(draw, draw.choice(NUMBERS))
    return repr(draw.choice((1, -1)) * draw.random() * 10.0 ** draw.randint(-20, 20))
