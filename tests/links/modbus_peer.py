"""The other end of a Modbus link, by pymodbus 3.0 and later: a server that is told what to hold, or a client.

  modbus_peer.py server PORT     lines on standard input: set co|di|hr|ir ADDRESS VALUE…, get co|di|hr|ir ADDRESS COUNT
  modbus_peer.py client PORT     lines: read co|di|hr|ir ADDRESS COUNT, write co|hr ADDRESS VALUE…
Each line is answered by one line of numbers, or "error …".
"""
import logging
import sys
import threading

logging.disable()

TABLES = {"co": 1, "di": 2, "hr": 3, "ir": 4}


def lines():
    for line in sys.stdin:
        words = line.split()
        if words:
            yield words


def answer(text):
    print(text, flush=True)


def serve(port):
    from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext
    try:
        from pymodbus.datastore import ModbusDeviceContext as Device  # 3.10 and later
    except ImportError:
        from pymodbus.datastore import ModbusSlaveContext as Device
    from pymodbus.server import StartTcpServer

    block = lambda: ModbusSequentialDataBlock(0, [0] * 400)
    device = Device(di=block(), co=block(), hr=block(), ir=block())
    try:
        context = ModbusServerContext(devices=device, single=True)
    except TypeError:
        context = ModbusServerContext(slaves=device, single=True)

    def run():
        address = ("127.0.0.1", port)
        try:
            StartTcpServer(context=context, address=address, allow_reuse_address=True)  # 3.0
        except TypeError:
            StartTcpServer(context=context, address=address)

    threading.Thread(target=run, daemon=True).start()
    answer("serving")
    for command, table, address, *rest in lines():
        if command == "set":
            device.setValues(TABLES[table], int(address), [int(word) for word in rest])
            answer("done")
        else:
            answer(" ".join(str(int(n)) for n in device.getValues(TABLES[table], int(address), int(rest[0]))))


def ask(port):
    from pymodbus.client import ModbusTcpClient

    client = ModbusTcpClient("127.0.0.1", port=port, timeout=3)
    answer("connected" if client.connect() else "error cannot connect")
    read = {"co": client.read_coils, "di": client.read_discrete_inputs, "hr": client.read_holding_registers,
            "ir": client.read_input_registers}
    for command, table, address, *rest in lines():
        if command == "read":
            count = int(rest[0])
            result = read[table](int(address), count=count)
        elif table == "co":
            result = client.write_coils(int(address), [word == "1" for word in rest])
        else:
            result = client.write_registers(int(address), [int(word) for word in rest])
        if result.isError():
            answer("error " + str(result).replace("\n", " "))
        elif command == "read":
            answer(" ".join(str(int(n)) for n in (result.bits if table in ("co", "di") else result.registers)[:count]))
        else:
            answer("done")


if __name__ == "__main__":
    (serve if sys.argv[1] == "server" else ask)(int(sys.argv[2]))
